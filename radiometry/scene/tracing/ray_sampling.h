// SPDX-License-Identifier: Apache-2.0
#pragma once

// Points on sides and directions above them, spread evenly: R_d, the additive recurrence of Roberts ("The unreasonable
// effectiveness of quasirandom sequences", 2018) with the powers of 1/phi_d, phi_d^(d+1) = phi_d + 1, shifted by random
// numbers of the receiver (Cranley and Patterson, SIAM J. Numer. Anal. 13, 1976).

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "radiometry/scene/facets.h"
#include "radiometry/stages/noise/random.h"

namespace radiometry::scene {

/// 2^64 / phi_D^k for k = 1 to D; phi_2 = 1.32471795724474603, phi_4 = 1.16730397826141868.
template <std::size_t D>
inline constexpr std::array<std::uint64_t, D> kSpreadStep{};
template <>
inline constexpr std::array<std::uint64_t, 2> kSpreadStep<2>{0xc13fa9a902a6328f, 0x91e10da5c79e7b1d};
template <>
inline constexpr std::array<std::uint64_t, 4> kSpreadStep<4>{0xdb4f0b9175ae2165, 0xbbe0563303a4615f, 0xa0f2ec75a1fe1576,
                                                             0x89e182857d9ed689};

/// Points in the unit cube of D dimensions, D numbers in [0, 1) each, that belong to a receiver and a seed.
template <std::size_t D>
class SpreadNumbers {
 public:
  SpreadNumbers(std::uint64_t receiver, std::uint64_t seed)
      : shift_(philox({static_cast<std::uint32_t>(receiver), static_cast<std::uint32_t>(receiver >> 32), D, 0}, seed)) {
  }

  std::array<double, D> operator()(std::uint64_t i) const {
    std::array<double, D> numbers;
    for (std::size_t k = 0; k < D; ++k)  // 53 bits of the sum modulo 1
      numbers[k] = 0x1p-53 * static_cast<double>(((std::uint64_t{shift_[k]} << 32) + i * kSpreadStep<D>[k]) >> 11);
    return numbers;
  }

 private:
  Bits128 shift_;
};

/// The triangles of a receiver, to pick points from by area.
class ReceiverSurface {
 public:
  ReceiverSurface(const Facets& facets, std::span<const Side> sides, double lift_m);

  struct Start {
    Point point;    ///< `lift_m` above the side, and no nearer than about that to the rim of its triangle
    Vector normal;  ///< of the side
    Side side;
  };
  /// Uniform over the area for `u` and `v` uniform in [0, 1).
  Start at(double u, double v) const;

 private:
  struct Piece {
    Point a;
    Vector ab, ac, normal;
    Side side;
    double until;  ///< share of the area up to and with this piece
  };
  std::vector<Piece> pieces_;
};

/// A direction above a surface with this normal, with a density proportional to the cosine (Malley): `u` and `v` in [0,
/// 1). The frame is that of Duff et al., J. Comput. Graph. Tech. 6(1), 2017.
inline Vector cosine_direction(const Vector& n, double u, double v) {
  const double sign = std::copysign(1.0, n[2]), a = -1.0 / (sign + n[2]), b = n[0] * n[1] * a;
  const Vector x{1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, y{b, sign + n[1] * n[1] * a, -n[1]};
  const double radius = std::sqrt(u), turn = 2.0 * std::numbers::pi * v;
  return (radius * std::cos(turn)) * x + (radius * std::sin(turn)) * y + std::sqrt(1.0 - u) * n;
}

}  // namespace radiometry::scene
