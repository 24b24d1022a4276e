// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units in which `mtf measure` states spatial frequencies. A measurement is in cycles per pixel along the normal of
// its edge. With square pixels p apart and the focal length F, one cycle per pixel is
//   1 / p              cy/mm, and lp/mm: a pair of lines is a cycle
//   F / p              cy/mrad in object space, with F in mm and p in um
//   2 x rows           lw/ph: line widths, two a cycle, in the height of the picture, whatever its orientation

#include <cstdint>
#include <optional>
#include <string_view>

namespace apps {

enum class FrequencyUnit { cy_px, cy_mm, lp_mm, cy_mrad, lw_ph };

/// "cy/px": the word of --unit, of headings and of CSV.
std::string_view unit_symbol(FrequencyUnit unit);
/// "cycles/pixel": the word of JSON, of axes and of sentences.
std::string_view unit_name(FrequencyUnit unit);

/// A unit, and what lengths it takes to get there.
struct FrequencyScale {
  FrequencyUnit unit = FrequencyUnit::cy_px;
  double per_cy_px = 1.0;  ///< one cycle per pixel in this unit
};

/// The unit for an image of so many rows. Throws UsageError that names the option which is missing.
FrequencyScale frequency_scale(FrequencyUnit unit, std::optional<double> pitch_um,
                               std::optional<double> focal_length_mm, std::int64_t rows);

}  // namespace apps
