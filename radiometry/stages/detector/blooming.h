// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blooming: charge above the full well spills into the neighbours.
//   excess = max(0, e - full well);   drain x excess is gone, half of the rest goes in either direction along the line
// and fills the wells that it meets, until all is absorbed or it leaves at the edge. Where charge from two directions
// meets at one well, the result is the mean of both orders, so that no direction is preferred, no pixel is above the
// full well, and
//   sum before = sum after + drained + left at the edges.
// Lines are the columns (the vertical channels of a CCD), the rows, or both: half of the excess along the columns
// first, then the rest along the rows. A line takes two passes, whatever the charge. Blooming takes the place of
// fill_well (adc.h) and needs the whole detector, since charge comes from anywhere in its line. (Theuwissen,
// Solid-State Imaging with Charge-Coupled Devices, ch. 6.)

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
    return std::tuple{optional(&Blooming::direction, "direction", "\"both\"",
                               "along which lines charge spills: columns, rows or both"),
                      optional(&Blooming::drain, "drain", 0.0, 1.0, "0.9",
                               "part of the charge above the full well that an anti-blooming drain takes")};
  }
};

/// Charge that has left the image, in electrons.
struct Spilled {
  double drained_e = 0.0;
  double left_e = 0.0;
};

/// Spills the electrons of a whole detector. A NaN pixel stays NaN and lets charge pass. Throws UsageError for values
/// out of their bounds and a full well that is not above 0.
Spilled bloom(mtf::ImageView<float> image, const Blooming& blooming, double full_well_e, int threads = 1);

}  // namespace radiometry
