// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/curve_gaps.h"

#include <algorithm>
#include <cmath>

#include "mtf/units.h"

namespace radiometry {
namespace {

/// Where the curve is not nearly 0, with the samples beside; without an end where it stops before it has come down.
Interval risen_range(const Spectrum& curve) {
  const double least = 0.01 * std::ranges::max(curve.value);
  const auto is_risen = [&](double value) { return value > 0.0 && value >= least; };
  Interval risen;
  for (std::size_t i = 0; i < curve.value.size() && !is_risen(curve.value[i]); ++i)
    risen.lo_um = curve.wavelength_um[i];
  for (std::size_t i = curve.value.size(); i > 0 && !is_risen(curve.value[i - 1]); --i)
    risen.hi_um = curve.wavelength_um[i - 1];
  return risen;
}

constexpr double kSamePlace = 1e-9;  // relative: wavelengths in other units are rounded

}  // namespace

Interval open_range(const Interval& band, std::span<const Spectrum> factors) {
  Interval open = band;
  for (const Spectrum& factor : factors) {
    const Interval risen = risen_range(factor);
    open = {std::max(open.lo_um, risen.lo_um), std::min(open.hi_um, risen.hi_um)};
  }
  return open;
}

std::string missing_words(const Spectrum& curve, const Interval& open) {
  const Interval own = range_of(curve), risen = risen_range(curve);
  std::string zero, ends;
  const auto add = [&](const Interval& missing, double last) {
    if (!(missing.hi_um > missing.lo_um * (1.0 + kSamePlace))) return;
    zero += (zero.empty() ? "" : " and ") + describe(missing);
    ends += (ends.empty() ? "" : " and ") + mtf::format_double(last);
  };
  if (risen.lo_um == 0.0) add({open.lo_um, std::min(own.lo_um, open.hi_um)}, curve.value.front());
  if (std::isinf(risen.hi_um)) add({std::max(own.hi_um, open.lo_um), open.hi_um}, curve.value.back());
  if (zero.empty()) return "";
  return curve.source + ": covers " + describe(own) + ", so that " + zero +
         " of the band counts as 0, while it ends at " + ends +
         "; continue the curve over the band, end it with 0 where nothing passes, or narrow [band]";
}

}  // namespace radiometry
