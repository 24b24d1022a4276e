// SPDX-License-Identifier: Apache-2.0
#pragma once

// From electrons to digital numbers.
//   count = clamp(round(electrons / electrons_per_count + offset), 0, 2^bits - 1)
// before it the well: electrons = min(electrons, full well). Counts stay in float images, which hold every whole number
// up to 24 bits and the nearest float above; `digitise_to` gives all of 32.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

enum class Rounding {
  nearest,  ///< halves upwards
  down      ///< truncation: half a count below on average
};
inline constexpr std::array<std::string_view, 2> kRoundingNames{"nearest", "down"};
constexpr std::span<const std::string_view> words(Rounding) { return kRoundingNames; }

struct Adc {
  double electrons_per_count = 1.0;
  double offset_counts = 0.0;
  int bits = 14;
  Rounding rounding = Rounding::nearest;

  double most_counts() const;  ///< 2^bits - 1

  static constexpr auto fields() {
    return std::tuple{required(&Adc::electrons_per_count, "electrons_per_count", "e-", 1e-30, 1e30, "\"420 e-\"",
                               "electrons of one count"),
                      optional(&Adc::offset_counts, "offset", -1e10, 1e10, "200", "counts without electrons"),
                      required(&Adc::bits, "bits", 1, 32, "14", "bits of a count"),
                      optional(&Adc::rounding, "rounding", "\"down\"", "nearest (halves upwards), or down")};
  }
};

/// The converter whose range is the full well.
Adc adc_for_well(double full_well_e, int bits);

/// A conversion as its loop takes it: floor(electrons x counts_per_electron + offset), held between 0 and `most`.
struct AdcScale {
  double counts_per_electron, offset, most;
};
/// Throws UsageError for an Adc out of its bounds.
AdcScale scale_of(const Adc& adc);

/// How many pixels were held at an end of the range.
struct Clipped {
  std::int64_t low = 0, high = 0;
};

/// image = min(image, full_well_e); NaN stays. Returns the number of pixels that were above. Throws UsageError for a
/// well that is not above 0.
Clipped fill_well(mtf::ImageView<float> image, double full_well_e, int threads = 1);

/// Counts the pixels that fill_well would hold; the image stays as it is.
Clipped above_well(mtf::ImageView<const float> image, double full_well_e, int threads = 1);

/// Electrons become counts in place. NaN stays NaN, infinities are at the ends. Throws UsageError for an Adc out of its
/// bounds.
Clipped digitise(mtf::ImageView<float> image, const Adc& adc, int threads = 1);

/// The same into integers, which hold 32 bits; NaN becomes 0. Both images have one size (UsageError for others).
Clipped digitise_to(mtf::ImageView<const float> electrons, const Adc& adc, mtf::ImageView<std::uint32_t> counts,
                    int threads = 1);

}  // namespace radiometry
