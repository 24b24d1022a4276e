// SPDX-License-Identifier: Apache-2.0
#pragma once

// Convection between a surface and the air beside it, in W/m2 away from the surface:
//   q = h (T - T_air) + c |T - T_air|^(1/3) (T - T_air)
// h holds what the wind drives, c what buoyancy drives; c depends on whether the surface is warmer or colder than the
// air and on its tilt. The closures are correlations: 20 to 30 % in h is usual, which is 1 to 3 K in a sunlit surface.
//   none      0: vacuum
//   linear    h = h0 + h1 v
//   mcadams   h = 5.7 + 3.8 v: a rough plate, fitted for v below 5 m/s (McAdams, Heat Transmission, 3rd ed., 1954;
//             Duffie & Beckman, 3.15); continued above, where it overestimates by up to 20 % at 30 m/s
//   tarp      natural (Walton, NBSIR 83-2655, 1983), with cos the cosine of the tilt from the vertical direction:
//               vertical                                          c = 1.31
//               warm side up, or cold side down                   c = 9.482 / (7.283 - |cos|)
//               warm side down, or cold side up                   c = 1.810 / (1.382 + |cos|)
//             and forced h = 2.537 R sqrt(P v / A), R the roughness (1.0 glass ... 2.17 stucco), P the perimeter and A
//             the area of the whole plane surface, all sides taken as windward; from plates in winds of some m/s

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace radiometry::heat {

/// Where a closure, or another formula, holds: the range of the quantity that it is made for, and what it is off by
/// beyond it.
struct Validity {
  std::string_view closure, quantity, unit;
  double lo = 0.0, hi = 0.0;
  std::string_view beyond;  ///< what is wrong there
};

/// Values that a run saw outside of such a range: how many, the first of them, and the one that is farthest out.
struct Beyond {
  std::size_t values = 0;
  double first_s = 0.0, extreme = 0.0;
  std::size_t first_place = 0;

  void see(const Validity& validity, double value, double time_s, std::size_t place = 0) {
    if (value >= validity.lo && value <= validity.hi) return;
    const auto out = [&](double x) { return std::max(validity.lo - x, x - validity.hi); };
    if (values++ == 0) {
      first_s = time_s;
      first_place = place;
      extreme = value;
    }
    if (out(value) > out(extreme)) extreme = value;
  }
};

struct NoConvection {};
struct LinearConvection {
  double h0_w_m2_k = 0.0, h1_j_m3_k = 0.0;  ///< h1 in W/m2/K for each m/s of wind
};
struct McAdams {};
struct Tarp {
  double roughness = 1.67;             ///< R: 2.17 very rough, 1.67 rough, 1.52 medium rough, 1.13 medium smooth, 1.0
  double perimeter_over_area_m = 4.0;  ///< P / A in 1/m: 4 for a square of 1 m
};
using Convection = std::variant<NoConvection, LinearConvection, McAdams, Tarp>;

/// `none`, `linear`, `mcadams` or `tarp`, as scene files and reports name them.
std::string name_of(const Convection& convection);

/// The winds that a closure was made for; nothing where it is what the user says.
std::optional<Validity> wind_validity(const Convection& convection);

/// h: the part in proportion to the temperature difference, W/m2/K. `wind_m_s` is not negative.
double forced_coefficient(const Convection& convection, double wind_m_s);

/// c of a surface warmer and of one colder than the air, W/m2/K^(4/3).
struct NaturalConvection {
  double warm = 0.0, cold = 0.0;
};
/// `up`: the vertical component of the outward unit normal: 1 for a surface that faces the zenith.
NaturalConvection natural_coefficient(const Convection& convection, double up);

/// Throws UsageError that begins with `where` for coefficients that are negative or not finite.
void require_valid(const Convection& convection, std::string_view where);

}  // namespace radiometry::heat
