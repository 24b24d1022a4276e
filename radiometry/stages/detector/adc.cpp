// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/adc.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace radiometry {
namespace {

constexpr std::int64_t kRowsAtOnce = 16;

/// Counts of a row; the numbers held at the ends are added up.
MTFKIT_CLONES void convert_row(const AdcScale& scale, std::int64_t width, const float* in, float* out,
                               Clipped& clipped) {
  std::int64_t low = 0, high = 0;
  for (std::int64_t x = 0; x < width; ++x) {
    const double count = std::floor(static_cast<double>(in[x]) * scale.counts_per_electron + scale.offset);
    low += count < 0.0 ? 1 : 0;
    high += count > scale.most ? 1 : 0;
    const double held = count < 0.0 ? 0.0 : count;  // NaN passes both
    out[x] = static_cast<float>(held > scale.most ? scale.most : held);
  }
  clipped.low += low;
  clipped.high += high;
}

MTFKIT_CLONES void convert_row(const AdcScale& scale, std::int64_t width, const float* in, std::uint32_t* out,
                               Clipped& clipped) {
  std::int64_t low = 0, high = 0;
  for (std::int64_t x = 0; x < width; ++x) {
    const double count = std::floor(static_cast<double>(in[x]) * scale.counts_per_electron + scale.offset);
    low += count < 0.0 ? 1 : 0;
    high += count > scale.most ? 1 : 0;
    const double held = count > 0.0 ? count : 0.0;
    out[x] = static_cast<std::uint32_t>(held > scale.most ? scale.most : held);
  }
  clipped.low += low;
  clipped.high += high;
}

template <class Work>
Clipped over_rows(std::int64_t height, int threads, Work work) {
  std::atomic<std::int64_t> low{0}, high{0};
  mtf::parallel_for(height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    Clipped clipped;
    for (std::int64_t y = begin; y < end; ++y) work(y, clipped);
    low += clipped.low;
    high += clipped.high;
  });
  return {low, high};
}

float well_of(double full_well_e) {
  if (!(full_well_e > 0.0))
    throw mtf::UsageError("full well of " + mtf::format_double(full_well_e) + " electrons; it has to be above 0");
  return static_cast<float>(full_well_e);
}

}  // namespace

AdcScale scale_of(const Adc& adc) {
  require_valid("adc", adc);
  return {1.0 / adc.electrons_per_count, adc.offset_counts + (adc.rounding == Rounding::nearest ? 0.5 : 0.0),
          adc.most_counts()};
}

double Adc::most_counts() const { return std::ldexp(1.0, bits) - 1.0; }

Adc adc_for_well(double full_well_e, int bits) {
  Adc adc{.bits = bits};
  require_valid("adc", adc);
  adc.electrons_per_count = full_well_e / adc.most_counts();
  require_valid("adc", adc);
  return adc;
}

Clipped fill_well(mtf::ImageView<float> image, double full_well_e, int threads) {
  const float well = well_of(full_well_e);
  return over_rows(image.height, threads, [&](std::int64_t y, Clipped& clipped) {
    float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x) {
      clipped.high += row[x] > well ? 1 : 0;
      row[x] = row[x] > well ? well : row[x];
    }
  });
}

Clipped above_well(mtf::ImageView<const float> image, double full_well_e, int threads) {
  const float well = well_of(full_well_e);
  return over_rows(image.height, threads, [&](std::int64_t y, Clipped& clipped) {
    const float* row = image.row(y);
    clipped.high += std::count_if(row, row + image.width, [&](float value) { return value >= well; });
  });
}

Clipped digitise(mtf::ImageView<float> image, const Adc& adc, int threads) {
  const AdcScale scale = scale_of(adc);
  return over_rows(image.height, threads, [&](std::int64_t y, Clipped& clipped) {
    convert_row(scale, image.width, image.row(y), image.row(y), clipped);
  });
}

Clipped digitise_to(mtf::ImageView<const float> electrons, const Adc& adc, mtf::ImageView<std::uint32_t> counts,
                    int threads) {
  const AdcScale scale = scale_of(adc);
  if (electrons.width != counts.width || electrons.height != counts.height)
    throw mtf::UsageError("digitise_to: an image of " + size_of(electrons.width, electrons.height) +
                          " electrons into one of " + size_of(counts.width, counts.height) +
                          " counts; give both one size");
  return over_rows(electrons.height, threads, [&](std::int64_t y, Clipped& clipped) {
    convert_row(scale, electrons.width, electrons.row(y), counts.row(y), clipped);
  });
}

}  // namespace radiometry
