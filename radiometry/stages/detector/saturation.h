// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether the value of a pixel still follows its light. Electrons are held at the full well, counts at 0 and at the
// largest one. Values scatter about their mean m with a standard deviation sigma, so that an end at c holds the share
//   Q((c - m) / sigma) above, Q((m - c) / sigma) below,   Q(x) = erfc(x / sqrt 2) / 2, for Gaussian scatter,
// and the mean of the held values rises by d E[min(x, c)] / dm = 1 - share of what the signal rises by. With half of
// the values or more, where the mean itself is at an end or beyond it, no figure of sensitivity is true any more; below
// that the share says how large their error is.

#include <cstdint>
#include <string>
#include <string_view>

#include "mtf/components/field.h"

namespace radiometry {

enum class RangeEnd { none, full_well, most_count, least_count };
/// "", "full_well", "most_count", "least_count".
std::string_view range_end_name(RangeEnd end);

/// The ends of a converter.
struct PixelRange {
  double least_e = -mtf::kInfinity;  ///< electrons of the well below which counts are held at 0,
  double most_e = mtf::kInfinity;    ///< and from which on they are held at the largest one
};

/// Mean electrons of a pixel, and how they scatter.
struct PixelScatter {
  double mean_e = 0.0;
  double well_e = 0.0;       ///< rms in the well: shot noise, responsivity, dark charge
  double converter_e = 0.0;  ///< rms before the converter: all noise
};

/// Half of the values, in the three digits of messages, so that a mean also counts as at an end where it misses the end
/// by rounding, or by the 1e-7 within which studies keep a constraint on the well.
inline constexpr double kHalfHeld = 0.4995;

/// The end of the range that holds most of the values.
struct Saturation {
  RangeEnd end = RangeEnd::none;  ///< none where no end holds values
  double mean_e = 0.0, end_e = 0.0;
  double sigmas = mtf::kInfinity;  ///< from the mean to that end, in standard deviations
  double held = 0.0;               ///< share of the values that are held at any end
  bool volts = false;              ///< of a thermal detector; else the values are electrons

  bool saturated() const { return held >= kHalfHeld; }
};

/// The slope of the mean and the standard deviation with an end x standard deviations away, both relative to those
/// without it. Their quotient is the factor by which a NETD is too good.
struct HeldScatter {
  double slope = 1.0, sd = 1.0;
};
HeldScatter held_scatter(double x);

Saturation saturation_of(const PixelScatter& pixel, const PixelRange& range, double full_well_e);

/// A number for messages: two digits that are not more than a value above 0, so that a limit that is written is kept.
std::string at_most(double value);

/// Which end holds how much, and which setting to change; "" where the ends are 4 sigma away or more and change no
/// figure by 1e-4.
std::string words(const Saturation& saturation);

/// Pixels of frames that are held at an end of the range.
struct HeldPixels {
  std::int64_t pixels = 0;  ///< of which
  std::int64_t full_well = 0, most_count = 0, least_count = 0;
  bool volts = false;  ///< of a thermal detector

  /// Of the end that holds most: pixels at the full well may be at the largest count too.
  double share() const;
  bool any() const { return full_well > 0 || most_count > 0 || least_count > 0; }
  HeldPixels& operator+=(const HeldPixels& other);
  friend bool operator==(const HeldPixels&, const HeldPixels&) = default;
};

/// "12 % of the pixels (9830 of 81920) at the full well, 6 % (4920) at the converter's largest count"; "" where none is
/// held.
std::string where_held(const HeldPixels& held);
/// The same as a warning, with the setting to change.
std::string words(const HeldPixels& held);

}  // namespace radiometry
