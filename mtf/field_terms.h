// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of a system that change over the field of view. A field point q is a place in the image,
//   q = (place - optical axis) / R,   +x right, +y down, R half the diagonal of the detector,
// so that |q| = 1 in the corners of a detector whose middle lies on the axis. A number of a presample component is
//   value(q) = value on the axis + sum of c_i t_i(q),   t = r, r2, r4, x, y, x2, xy, y2,   r = |q|
// in the unit that the component holds it in, or takes what a table of values at positions adds to that of the axis
// (FieldMap), and an angle may turn with the field point. System::at(q) is the system that a pixel there sees. The
// definition of an image: a pixel sees what the isoplanatic sensor with that pixel's OTF would see.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/units.h"

namespace mtf {

template <class S>
struct FieldPoint {
  S x{};
  S y{};

  bool operator==(const FieldPoint&) const = default;
};

inline constexpr std::array<std::string_view, 8> kFieldTerms{"r", "r2", "r4", "x", "y", "x2", "xy", "y2"};

template <class S>
std::array<S, 8> field_terms(const FieldPoint<S>& q) {
  using std::sqrt;
  const S r2 = q.x * q.x + q.y * q.y;
  return {r2 > S(0) ? S(sqrt(r2)) : S(0), r2, r2 * r2, q.x, q.y, q.x * q.x, q.x * q.y, q.y * q.y};
}

/// In what a table states its positions. Lengths, slopes (tangents of field angles) and shares of the half diagonal are
/// counted from the optical axis; pixels from the corner of the detector, distances in pixels from the axis.
enum class FieldUnit { half_diagonal, millimetre, slope, pixel };

/// Values at positions of the field, and between them the polyharmonic interpolant (Duchon, 1977)
///   value(u) = sum of weight[i] |u - u_i|^n + polynomial(u),   u = (position - middle) / scale,
/// of which the polynomial is the part of degree 1 (n = 3), 2 or 3 (n = 5) that the positions determine, so that fields
/// that are such polynomials are met exactly. Made by make_field_map (mtf/field/field_map.h). Or values in an image of
/// the whole detector, at the middles of samples of any number, row after row in each column: between them cubics
/// through the four around along each axis, which meet parabolas exactly (Keys, 1981). Made by make_field_image.
struct FieldMap {
  static constexpr std::size_t kMostTerms = 10;  ///< of a polynomial in x and y of degree 3
  struct Column {
    std::string name;
    const Unit* unit = nullptr;  ///< null: plain numbers
    std::vector<double> value;   ///< at each position
    std::vector<double> weight{};
    std::array<double, kMostTerms> polynomial{};
    /// Of positions that are left out one at a time, the rms and the largest of what the others miss there; nothing
    /// where there are too few.
    std::optional<std::array<double, 2>> missed{};

    bool operator==(const Column&) const = default;
  };

  std::string source;  ///< file
  FieldUnit unit = FieldUnit::half_diagonal;
  bool radial = false;  ///< positions are distances from the optical axis; their y is 0
  std::vector<FieldPoint<double>> position;
  std::vector<Column> column;
  int columns = 0, rows = 0;  ///< of an image, whose unit is the pixel and which has no positions
  // As made:
  int degree = 0;
  FieldPoint<double> middle{};
  double scale = 1.0;
  std::vector<FieldPoint<double>> hull{};  ///< of the positions, in u; of distances their ends

  bool operator==(const FieldMap&) const = default;

  bool is_image() const { return columns > 0; }
  /// Of an image: throws UsageError unless it has the shape of a detector of so many pixels.
  void require_shape_of(int detector_columns, int detector_rows) const;
  /// Whether a place, in the map's own unit (of an image, in samples from its corner), lies among the positions, or
  /// beyond them by no more than 1 % of their width.
  bool covers(const FieldPoint<double>& place) const;
  /// "coma.csv covers 0 to 10 mm, and 12.4 mm is asked for".
  std::string outside_text(const FieldPoint<double>& place) const;

  /// The terms of the polynomial at u: 1, x, y, x^2, xy, y^2, x^3 ...; of distances the powers of x alone.
  template <class S>
  void each_term(const FieldPoint<S>& u, const auto& take) const {
    std::size_t k = 0;
    for (int order = 0; order <= degree; ++order)
      for (int j = 0; j <= (radial ? 0 : order); ++j) {
        S term(1);
        for (int i = 0; i < order; ++i) term *= i < j ? u.y : u.x;
        take(k++, term);
      }
  }
  /// |u|^n by the square of |u|.
  template <class S>
  S kernel(const S& square) const {
    using std::sqrt;
    if (!(square > S(0))) return S(0);  // whose root has no derivative
    const S cube = square * sqrt(square);
    return degree < 2 ? cube : S(cube * square);
  }
  /// Of n samples, the four about a place and their weights. Before the first goes the parabola through the first
  /// three, behind the last alike (R. G. Keys, IEEE Trans. ASSP 29, 1153 (1981)), of two samples their line, so that
  /// parabolas are met exactly everywhere.
  template <class S>
  struct Cubic {
    std::array<std::size_t, 4> sample;
    std::array<S, 4> weight;
    Cubic(const S& place, double whole, int n) {
      const int i = std::clamp(static_cast<int>(std::floor(whole)), 0, n - 2);
      const S t = place - S(i);
      weight = {t * (t * (S(1) - S(0.5) * t) - S(0.5)), S(1) + t * t * (S(1.5) * t - S(2.5)),
                t * (S(0.5) + t * (S(2) - S(1.5) * t)), t * t * (S(0.5) * t - S(0.5))};
      for (int k = 0; k < 4; ++k)
        sample[static_cast<std::size_t>(k)] = static_cast<std::size_t>(std::clamp(i + k - 1, 0, n - 1));
      const S parabola(n > 2 ? 1 : 0);
      const auto extend = [&](std::size_t beyond, std::size_t end, std::size_t next, std::size_t third) {
        weight[end] += (S(2) + parabola) * weight[beyond];
        weight[next] -= (S(1) + S(2) * parabola) * weight[beyond];
        weight[third] += parabola * weight[beyond];
        weight[beyond] = S(0);
      };
      if (i == 0) extend(0, 1, 2, 3);
      if (i == n - 2) extend(3, 2, 1, 0);
    }
  };
  /// At a place in samples from the corner of the image; `x`, `y`: the same as numbers.
  template <class S>
  S of_image(std::size_t which, const FieldPoint<S>& place, double x, double y) const {
    const Cubic<S> along(place.x - S(0.5), x - 0.5, columns), across(place.y - S(0.5), y - 0.5, rows);
    S sum(0);
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t i = 0; i < 4; ++i)
        sum += across.weight[j] * along.weight[i] *
               S(column[which].value[across.sample[j] * static_cast<std::size_t>(columns) + along.sample[i]]);
    return sum;
  }
  template <class S>
  S at(std::size_t which, const FieldPoint<S>& place) const {
    const auto scaled = [this](const FieldPoint<S>& p) {
      return FieldPoint<S>{(p.x - S(middle.x)) / S(scale), (p.y - S(middle.y)) / S(scale)};
    };
    const FieldPoint<S> u = scaled(place);
    const Column& c = column[which];
    S sum(0);
    for (std::size_t i = 0; i < position.size(); ++i) {
      const FieldPoint<S> v = scaled({S(position[i].x), S(position[i].y)});
      sum += S(c.weight[i]) * kernel(S((u.x - v.x) * (u.x - v.x) + (u.y - v.y) * (u.y - v.y)));
    }
    each_term(u, [&](std::size_t k, const S& term) { sum += S(c.polynomial[k]) * term; });
    return sum;
  }
};

/// A number that changes over the field.
template <class S>
struct FieldNumber {
  std::size_t entry = 0;                  ///< of the presample list
  std::size_t field = 0;                  ///< row of its field table
  std::size_t element = 0;                ///< of a list; of a pair x, y its part: 0 x or both, 1 y
  std::array<S, 8> coefficient{};         ///< of kFieldTerms
  std::shared_ptr<const FieldMap> map{};  ///< null: none
  std::size_t column = 0;                 ///< of the map,
  double factor = 1.0;                    ///< whose values times this are in the unit of the number

  bool operator==(const FieldNumber& other) const {
    return entry == other.entry && field == other.field && element == other.element &&
           coefficient == other.coefficient && column == other.column && factor == other.factor &&
           (map == other.map || (map && other.map && *map == *other.map));
  }
};

/// An angle that is counted from the direction of the field point, in which the pixel lies from the axis.
struct FieldAngle {
  std::size_t entry = 0, field = 0;  ///< as above

  bool operator==(const FieldAngle&) const = default;
};

template <class S>
struct FieldDependence {
  S axis_x_px{}, axis_y_px{};  ///< optical axis from the detector's middle
  std::vector<FieldNumber<S>> numbers;
  std::vector<FieldAngle> angles;

  bool empty() const { return numbers.empty() && angles.empty(); }
  bool operator==(const FieldDependence&) const = default;
};

}  // namespace mtf
