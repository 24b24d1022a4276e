// SPDX-License-Identifier: Apache-2.0
#pragma once

// Quantities of one dimension each: what a program hands to the toolkit in place of bare numbers.
//   const Length pitch = micrometres(15);    // or 15_um, with mtf/literals.h
//   pitch / millimetres(1)                   // 0.015: the quotient of two of a kind is a number
//   millimetres(10) / seconds(2)             // a Speed
// A number without a unit is no quantity, and no dimension passes for another: either does not compile. Units and
// conversion factors are those of mtf/units.h; a quantity keeps the unit in which it was given. Spatial frequencies per
// mm, per mrad and per pixel become each other by a Frame alone (mtf/frame.h), so they are neither added nor divided.

#include <string_view>

#include "mtf/units.h"

namespace mtf {

/// Throws UsageError unless there is a unit of that name and dimension.
Quantity quantity_of(double value, std::string_view unit, Dimension dimension);

template <Dimension dimension>
class QuantityOf {
  static constexpr bool kConverts = dimension != Dimension::frequency;

 public:
  QuantityOf(double value, std::string_view unit) : quantity_(quantity_of(value, unit, dimension)) {}

  const Quantity& quantity() const { return quantity_; }

  QuantityOf operator-() const { return -1.0 * *this; }
  friend QuantityOf operator*(double factor, const QuantityOf& a) {
    return {factor * a.quantity_.value, a.quantity_.unit->name};
  }
  friend QuantityOf operator*(const QuantityOf& a, double factor) { return factor * a; }
  friend QuantityOf operator/(const QuantityOf& a, double divisor) {
    return {a.quantity_.value / divisor, a.quantity_.unit->name};
  }
  friend QuantityOf operator+(const QuantityOf& a, const QuantityOf& b) requires kConverts {
    const std::string_view unit = a.quantity_.unit->name;
    return {a.quantity_.value + convert(b.quantity_, unit), unit};
  }
  friend QuantityOf operator-(const QuantityOf& a, const QuantityOf& b) requires kConverts { return a + (-b); }
  /// How many times b goes into a.
  friend double operator/(const QuantityOf& a, const QuantityOf& b) requires kConverts {
    return convert(a.quantity_, b.quantity_.unit->name) / b.quantity_.value;
  }
  /// Compared in the larger unit of the two: 15_mm == 15000_um. Spatial frequencies are equal in the same unit alone.
  friend bool operator==(const QuantityOf& a, const QuantityOf& b) {
    const Quantity &p = a.quantity_, &q = b.quantity_;
    if constexpr (!kConverts) return p.unit == q.unit && p.value == q.value;
    const std::string_view unit = p.unit->factor > q.unit->factor ? p.unit->name : q.unit->name;
    return convert(p, unit) == convert(q, unit);
  }

 private:
  Quantity quantity_;
};

using Length = QuantityOf<Dimension::length>;
using Angle = QuantityOf<Dimension::angle>;
using Pixels = QuantityOf<Dimension::pixel>;
using Frequency = QuantityOf<Dimension::frequency>;  ///< spatial: per mm of the focal plane, per mrad, per pixel
using TemporalFrequency = QuantityOf<Dimension::temporal>;
using Duration = QuantityOf<Dimension::time>;
using Speed = QuantityOf<Dimension::velocity>;    ///< over the focal plane
using AngularRate = QuantityOf<Dimension::rate>;  ///< in object space
using Acceleration = QuantityOf<Dimension::acceleration>;
using AngularAcceleration = QuantityOf<Dimension::angular_acceleration>;
using Luminance = QuantityOf<Dimension::luminance>;

inline Length nanometres(double value) { return {value, "nm"}; }
inline Length micrometres(double value) { return {value, "um"}; }
inline Length millimetres(double value) { return {value, "mm"}; }
inline Length metres(double value) { return {value, "m"}; }
inline Length kilometres(double value) { return {value, "km"}; }

inline Angle microradians(double value) { return {value, "urad"}; }
inline Angle milliradians(double value) { return {value, "mrad"}; }
inline Angle degrees(double value) { return {value, "deg"}; }

inline Pixels pixels(double value) { return {value, "px"}; }

inline Frequency cycles_per_mm(double value) { return {value, "cy/mm"}; }
inline Frequency cycles_per_mrad(double value) { return {value, "cy/mrad"}; }
inline Frequency cycles_per_px(double value) { return {value, "cy/px"}; }

inline TemporalFrequency hertz(double value) { return {value, "Hz"}; }
inline TemporalFrequency kilohertz(double value) { return {value, "kHz"}; }
inline TemporalFrequency megahertz(double value) { return {value, "MHz"}; }

inline Duration microseconds(double value) { return {value, "us"}; }
inline Duration milliseconds(double value) { return {value, "ms"}; }
inline Duration seconds(double value) { return {value, "s"}; }

inline Speed micrometres_per_second(double value) { return {value, "um/s"}; }
inline AngularRate microradians_per_second(double value) { return {value, "urad/s"}; }
inline Acceleration micrometres_per_second2(double value) { return {value, "um/s^2"}; }
inline AngularAcceleration microradians_per_second2(double value) { return {value, "urad/s^2"}; }
inline Luminance candelas_per_m2(double value) { return {value, "cd/m^2"}; }

inline Speed operator/(const Length& a, const Duration& b) {
  return micrometres_per_second((a / micrometres(1.0)) / (b / seconds(1.0)));
}
inline AngularRate operator/(const Angle& a, const Duration& b) {
  return microradians_per_second((a / microradians(1.0)) / (b / seconds(1.0)));
}
inline Acceleration operator/(const Speed& a, const Duration& b) {
  return micrometres_per_second2((a / micrometres_per_second(1.0)) / (b / seconds(1.0)));
}
inline AngularAcceleration operator/(const AngularRate& a, const Duration& b) {
  return microradians_per_second2((a / microradians_per_second(1.0)) / (b / seconds(1.0)));
}

}  // namespace mtf
