// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is the same to the last bit, NaN and the sign of zero included: values of a field, which a file that was written
// and read again has to give back, and components and lists of them that have the same OTF.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>

#include "mtf/system.h"

namespace mtf {

inline bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
inline bool same_bits(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() == b.has_value() && (!a || same_bits(*a, *b));
}
inline bool same_bits(const Extent<double>& a, const Extent<double>& b) {
  return a.unit == b.unit && same_bits(a.value, b.value);
}
inline bool same_bits(const AxisPair<double>& a, const AxisPair<double>& b) {
  return a.split == b.split && same_bits(a.x, b.x) && (!a.split || same_bits(a.y, b.y));
}
inline bool same_bits(const SpatialFrequency<double>& a, const SpatialFrequency<double>& b) {
  return a.unit == b.unit && same_bits(a.value, b.value);
}
inline bool same_bits(int a, int b) { return a == b; }
inline bool same_bits(const Choice& a, const Choice& b) { return a.index == b.index; }
inline bool same_bits(const Coefficients<double>& a, const Coefficients<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double s, double t) { return same_bits(s, t); });
}
inline bool same_bits(const Taps<double>& a, const Taps<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return same_bits(x, y); });
}
inline bool same_bits(const std::shared_ptr<const Curve>& a, const std::shared_ptr<const Curve>& b) {
  return a == b || (a && b && a->frequency == b->frequency && a->value == b->value && a->unit == b->unit);
}
inline bool same_bits(const CurveSum<double>& a, const CurveSum<double>& b) {
  return std::ranges::equal(a.curves, b.curves, [](const auto& x, const auto& y) { return same_bits(x, y); }) &&
         same_bits(a.weight, b.weight);
}

/// True when two fields of one row have the same value.
bool same_value(const FieldRef<double>& a, const FieldRef<double>& b);
/// True when both are of one kind and have the same values.
bool same_component(const Component<double>& a, const Component<double>& b);
/// True when frame, optics, air and band, around any component, are the same.
bool same_surroundings(const System<double>& a, const System<double>& b);

/// True when the list of that stage has the same OTF in both systems: equal kinds and values in the same order, and
/// equal frame, optics and band around them. Labels and names do not count. False may be said of OTFs that are equal
/// all the same: the integration time matters to motion only, but is compared for every list that is not empty.
bool same_list(const System<double>& a, const System<double>& b, Stage stage);

}  // namespace mtf
