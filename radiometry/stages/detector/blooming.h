// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blooming: charge above the full well spills into the neighbours.
//   excess = max(0, e - full well);   drain x excess is gone, half of the rest goes either way along the line
// and fills whatever room it meets on its way, until all is absorbed or it leaves at the edge. Where charge of two
// directions wants the same room, the result is the mean of either going first; so it has no preferred direction, no
// pixel is above the full well, and
//   sum before = sum after + drained + left at the edges.
// Lines are the columns (the vertical channels of a CCD), the rows, or both: half of the excess along the columns
// first, then the rest along the rows. Two passes over a line, whatever the charge. It takes the place of fill_well
// (adc.h), on the whole detector: charge comes from anywhere in its line. (Theuwissen, Solid-State Imaging with
// Charge-Coupled Devices, ch. 6.)

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

enum class BloomingDirection { columns, rows, both };
inline constexpr std::array<std::string_view, 3> kBloomingDirectionNames{"columns", "rows", "both"};
constexpr std::span<const std::string_view> words(BloomingDirection) { return kBloomingDirectionNames; }

struct Blooming {
  BloomingDirection direction = BloomingDirection::columns;
  double drain = 0.0;

  static constexpr auto fields() {
    return std::tuple{
        Field{FieldInfo{.name = "direction",
                        .presence = mtf::Presence::optional,
                        .example = "\"both\"",
                        .doc = "along which lines charge spills: columns, rows or both"},
              &Blooming::direction},
        Field{FieldInfo{.name = "drain",
                        .lo = 0.0,
                        .hi = 1.0,
                        .presence = mtf::Presence::optional,
                        .example = "0.9",
                        .doc = "part of the charge above the full well that an anti-blooming drain takes"},
              &Blooming::drain}};
  }
};

/// Where charge went that is not in the image any more, electrons.
struct Spilled {
  double drained_e = 0.0;
  double left_e = 0.0;
};

/// Spills the electrons of a whole detector. A NaN pixel stays NaN and lets charge pass. Throws UsageError for values
/// out of their bounds and a full well that is not above 0.
Spilled bloom(mtf::ImageView<float> image, const Blooming& blooming, double full_well_e, int threads = 1);

}  // namespace radiometry
