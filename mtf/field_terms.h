// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of a system that change over the field of view. A field point q is a place in the image,
//   q = (place - optical axis) / R,   +x right, +y down, R half the diagonal of the detector,
// so that |q| = 1 in the corners of a detector whose middle lies on the axis. A number of a presample component is
//   value(q) = value on the axis + sum of c_i t_i(q),   t = r, r2, r4, x, y, x2, xy, y2,   r = |q|
// in the unit that the component holds it in, and an angle may turn with the field point. System::at(q) is the system
// that a pixel there sees. The definition of an image: a pixel sees what the isoplanatic sensor with that pixel's OTF
// would see.

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

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

/// A number that changes over the field.
template <class S>
struct FieldNumber {
  std::size_t entry = 0;           ///< of the presample list
  std::size_t field = 0;           ///< row of its field table
  std::size_t element = 0;         ///< of a list; of a pair x, y its part: 0 x or both, 1 y
  std::array<S, 8> coefficient{};  ///< of kFieldTerms

  bool operator==(const FieldNumber&) const = default;
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
