// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/noise.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/units.h"
#include "radiometry/stages/noise/noise_lanes.h"

namespace radiometry {
namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 32;
constexpr std::int64_t kRowsAtOnce = 16;

/// Calls work(half column, offset, first, count) for the blocks of lanes that cover columns [x, x + width): the
/// `count` lanes from `offset` on are the columns from x + first on.
template <class Work>
void for_each_block(std::int64_t x, std::int64_t width, Work work) {
  std::int64_t offset = x % 2;
  for (std::int64_t first = 0; first < width;) {
    const std::int64_t count = std::min(kNoiseLanes - offset, width - first);
    work(static_cast<std::uint32_t>((x + first) / 2), offset, first, count);
    first += count;
    offset = 0;
  }
}

template <class Work>
void for_each_row(mtf::ImageView<float> image, const NoiseKey& key, Stream stream, Origin origin, int threads,
                  std::int64_t every, Work work) {
  require_on_detector(origin, image.width, image.height);
  every = std::clamp<std::int64_t>(every, 1, std::max<std::int64_t>(1, image.height));
  const std::int64_t rows = (image.height + every - 1) / every;
  mtf::parallel_for(rows, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin * every; y < end * every && y < image.height; y += every)
      work(RandomRow{key, stream, static_cast<std::uint32_t>(origin.y + y)}, image.row(y));
  });
}

}  // namespace

void require_on_detector(Origin origin, std::int64_t width, std::int64_t height) {
  if (origin.x < 0 || origin.y < 0 || origin.x > kMostPixels - width || origin.y > kMostPixels - height)
    throw mtf::UsageError("noise: a region of " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels from column " + std::to_string(origin.x) + ", row " + std::to_string(origin.y) +
                          "; columns and rows are counted from 0 to below 2^32");
}

void gaussian_row(const RandomRow& row, std::int64_t x, std::int64_t count, float* out) {
  require_on_detector({x, 0}, count, 1);
  alignas(64) float lanes[kNoiseLanes];
  for_each_block(x, count, [&](std::uint32_t half, std::int64_t offset, std::int64_t first, std::int64_t n) {
    gaussian_lanes(row, half, lanes);
    std::copy_n(lanes + offset, n, out + first);
  });
}

void add_gaussian(mtf::ImageView<float> image, double sigma, const NoiseKey& key, Stream stream, Origin origin,
                  int threads, std::int64_t every) {
  if (!(sigma >= 0.0) || !std::isfinite(sigma))
    throw mtf::UsageError("noise of " + mtf::format_double(sigma) + " rms; it has to be 0 or above and finite");
  if (sigma == 0.0) return;
  const auto s = static_cast<float>(sigma);
  for_each_row(image, key, stream, origin, threads, every, [&](const RandomRow& random, float* row) {
    alignas(64) float lanes[kNoiseLanes];
    for_each_block(origin.x, image.width,
                   [&](std::uint32_t half, std::int64_t offset, std::int64_t first, std::int64_t n) {
                     gaussian_lanes(random, half, lanes);
                     for (std::int64_t i = 0; i < n; ++i) row[first + i] += s * lanes[offset + i];
                   });
  });
}

void shot_noise(mtf::ImageView<float> image, const NoiseKey& key, Origin origin, int threads, std::int64_t every) {
  for_each_row(image, key, Stream::shot, origin, threads, every, [&](const RandomRow& random, float* row) {
    alignas(64) float mean[kNoiseLanes], count[kNoiseLanes];
    for_each_block(origin.x, image.width,
                   [&](std::uint32_t half, std::int64_t offset, std::int64_t first, std::int64_t n) {
                     if (n < kNoiseLanes) std::fill_n(mean, kNoiseLanes, row[first]);
                     std::copy_n(row + first, n, mean + offset);
                     poisson_lanes(random, half, mean, count);
                     std::copy_n(count + offset, n, row + first);
                   });
  });
}

}  // namespace radiometry
