// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/flicker.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace radiometry {
namespace {

using mtf::UsageError;

constexpr std::int64_t kLinesAtOnce = 16;
/// Scale of the sum, and weights of the first octaves that bring it closest to 1/f up to the Nyquist frequency.
constexpr double kLevel = 2.0829;
constexpr double kFirstWeights[] = {1.061, 1.763, 0.826};

double weight(int octave) { return octave < 3 ? kFirstWeights[octave] : 1.0; }

/// The octaves end with the first whose numbers are further apart than a frame is long.
int octaves(std::int64_t columns, std::int64_t rows) {
  int count = 1;
  for (std::int64_t pixels = columns * rows - 1; pixels > 0; pixels >>= 1) ++count;
  return count;
}

void require_detector(const Flicker& flicker, std::int64_t columns, std::int64_t rows) {
  require_valid("flicker", flicker);
  if (columns < 1 || rows < 1 || columns > (std::int64_t{1} << 62) / rows)
    throw UsageError("flicker: a detector of " + size_of(columns, rows) + " pixels; it needs from 1 to 2^62 of them");
}

Stream stream_of(int octave) {
  return static_cast<Stream>(static_cast<std::uint32_t>(Stream::flicker) + (static_cast<std::uint32_t>(octave) << 8));
}

/// sum[i] += value + t rise, t = (offset + i) / 2^octave.
MTFKIT_CLONES void add_line(float value, float rise, int octave, std::uint64_t offset, std::size_t count, float* sum) {
  // A float holds 24 bits of t; the others are cut off.
  const int cut = std::max(0, octave - 24);
  const float step = 1.0F / static_cast<float>(std::int32_t{1} << (octave - cut));
  if (cut == 0) {
    const auto start = static_cast<std::int32_t>(offset), n = static_cast<std::int32_t>(count);
    for (std::int32_t i = 0; i < n; ++i) sum[i] += value + static_cast<float>(start + i) * step * rise;
  } else {
    for (std::size_t i = 0; i < count; ++i)
      sum[i] += value + static_cast<float>(static_cast<std::int32_t>((offset + i) >> cut)) * step * rise;
  }
}

/// One octave in one frame: random numbers at whole multiples of 2^octave, straight lines between them.
struct Octave {
  NoiseKey key;
  int octave = 0;
  std::uint64_t shift = 0;  ///< place of the first pixel
  float scale = 0.0F;

  Octave(const NoiseKey& frame, int number, double density) : key(frame), octave(number) {
    // Row 2^32 - 1 is beyond those from which numbers are taken.
    const Bits128 bits = RandomRow{key, stream_of(octave), 0xffffffffU}.pair(0);
    shift = ((std::uint64_t{bits[0]} << 32) | bits[1]) & ((std::uint64_t{1} << octave) - 1);
    scale = static_cast<float>(std::sqrt(density * kLevel * weight(octave)));
  }

  /// numbers[i] = that of first + i, for `count` of them.
  void draw(std::uint64_t first, std::int64_t count, std::vector<float>& numbers) const {
    numbers.resize(static_cast<std::size_t>(count));
    constexpr std::uint64_t kColumns = std::uint64_t{1} << 31;
    for (std::int64_t done = 0; done < count;) {
      const std::uint64_t place = first + static_cast<std::uint64_t>(done), column = place % kColumns;
      const std::int64_t n = std::min(count - done, static_cast<std::int64_t>(kColumns - column));
      gaussian_row({key, stream_of(octave), static_cast<std::uint32_t>(place / kColumns)},
                   static_cast<std::int64_t>(column), n, numbers.data() + done);
      done += n;
    }
  }

  /// sum[i] += the octave at pixel first + i of the readout.
  void add(std::uint64_t first, std::vector<float>& sum, std::vector<float>& numbers) const {
    const std::uint64_t begin = first + shift, spacing = std::uint64_t{1} << octave;
    const std::uint64_t knot = begin >> octave, last = (begin + sum.size() - 1) >> octave;
    draw(knot, static_cast<std::int64_t>(last - knot) + 2, numbers);
    if (octave == 0) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += scale * numbers[i];
      return;
    }
    std::uint64_t offset = begin & (spacing - 1);
    const float* number = numbers.data();
    for (std::size_t done = 0; done < sum.size(); ++number) {
      const std::size_t count = std::min<std::uint64_t>(spacing - offset, sum.size() - done);
      add_line(scale * number[0], scale * (number[1] - number[0]), octave, offset, count, sum.data() + done);
      done += count;
      offset = 0;
    }
  }
};

}  // namespace

double flicker_density(const Flicker& flicker, std::int64_t columns, std::int64_t rows, double f_cy_px) {
  require_detector(flicker, columns, rows);
  double sum = 0.0;
  for (int octave = 0; octave < octaves(columns, rows); ++octave) {
    const double spacing = std::ldexp(1.0, octave);
    const double d = mtf::sin_pi(spacing * f_cy_px) / (spacing * mtf::sin_pi(f_cy_px));
    sum += weight(octave) * spacing * d * d * d * d;
  }
  return flicker.white_e * flicker.white_e * flicker.corner_cy_px * kLevel * sum;
}

double flicker_variance(const Flicker& flicker, std::int64_t columns, std::int64_t rows) {
  require_detector(flicker, columns, rows);
  double sum = 0.0;
  for (int octave = 0; octave < octaves(columns, rows); ++octave)
    sum += weight(octave) * (2.0 + std::ldexp(1.0, -2 * octave)) / 3.0;  // mean of (1 - t)^2 + t^2 over the places
  return flicker.white_e * flicker.white_e * flicker.corner_cy_px * kLevel * sum;
}

void add_flicker(mtf::ImageView<float> image, const Flicker& flicker, std::int64_t columns, std::int64_t rows,
                 const NoiseKey& key, Origin origin, int threads) {
  require_detector(flicker, columns, rows);
  if (origin.x < 0 || origin.y < 0 || image.width > columns || image.height > rows ||
      origin.x > columns - image.width || origin.y > rows - image.height)
    throw UsageError("flicker: a region of " + size_of(image.width, image.height) + " pixels from column " +
                     std::to_string(origin.x) + ", row " + std::to_string(origin.y) + " is outside a detector of " +
                     size_of(columns, rows));
  const double density = flicker.white_e * flicker.white_e * flicker.corner_cy_px;
  if (density == 0.0 || image.width == 0 || image.height == 0) return;
  std::vector<Octave> parts;
  for (int octave = 0; octave < octaves(columns, rows); ++octave) parts.emplace_back(key, octave, density);

  const bool by_rows = flicker.order == ReadoutOrder::rows;
  const std::int64_t lines = by_rows ? image.height : image.width, length = by_rows ? image.width : image.height;
  const std::int64_t step = by_rows ? 1 : image.stride;
  mtf::parallel_for(lines, kLinesAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> noise(static_cast<std::size_t>(length)), numbers;
    for (std::int64_t line = begin; line < end; ++line) {
      const std::int64_t first = by_rows ? (origin.y + line) * columns + origin.x : (origin.x + line) * rows + origin.y;
      std::fill(noise.begin(), noise.end(), 0.0F);
      for (const Octave& octave : parts) octave.add(static_cast<std::uint64_t>(first), noise, numbers);
      float* out = by_rows ? image.row(line) : image.data + line;
      for (std::int64_t i = 0; i < length; ++i) out[i * step] += noise[static_cast<std::size_t>(i)];
    }
  });
}

}  // namespace radiometry
