// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/frame_flicker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "mtf/error.h"
#include "mtf/math/special.h"
#include "mtf/units.h"

namespace radiometry {
namespace {

/// An octave whose numbers are 2^i frames apart has its variance about kMiddle 2^-i cycles per frame (the mean
/// logarithm of the frequency over the spectrum of a half cosine).
constexpr double kMiddle = 0.12880540238530611;
constexpr double kMostOctaves = 30.0;  // frames are numbered in 31 bits

struct Parts {
  std::vector<double> octaves{};  ///< their variances, from 2 frames apart on
  double white = 0.0;
};

Parts parts_of(const FrameFlicker& noise) {
  if (!(noise.strength >= 0.0 && noise.lowest > 0.0 && noise.highest > noise.lowest && std::isfinite(noise.highest)))
    throw mtf::UsageError("1/f noise of frames: strength " + mtf::format_double(noise.strength) + " from " +
                          mtf::format_double(noise.lowest) + " to " + mtf::format_double(noise.highest) +
                          " cycles per frame; frequencies are above 0 and rise, the strength is 0 or above");
  // Above the first octave is what new numbers have, which is flat: the less folds on it, the more falls with
  // frequency.
  const double first = 1.48 + 0.064 * std::max(0.0, 1.0 / std::max(0.25, noise.highest * noise.highest) - 0.25);
  Parts parts{.white = frame_flicker_variance(noise)};
  // Octaves down to `lowest`, of the last one a part.
  double left = std::min(std::log2(kMiddle / noise.lowest) - 0.5, kMostOctaves);
  for (; left > 0.0; left -= 1.0) {
    const double one = noise.strength * std::numbers::ln2 * (parts.octaves.empty() ? first : 1.0) * std::min(left, 1.0);
    if (one > parts.white) break;
    parts.octaves.push_back(one);
    parts.white -= one;
  }
  return parts;
}

Stream stream_of(int octave) {
  return static_cast<Stream>(static_cast<std::uint32_t>(Stream::frame_flicker) +
                             (static_cast<std::uint32_t>(octave) << 8));
}

}  // namespace

double frame_flicker_variance(const FrameFlicker& noise) {
  return noise.strength * std::log(noise.highest / noise.lowest);
}

double frame_flicker_mean_variance(const FrameFlicker& noise, int frames) {
  const Parts parts = parts_of(noise);
  const double n = frames;
  double variance = parts.white / n;
  for (int octave = 1; octave <= std::ssize(parts.octaves); ++octave) {
    // Two frames k apart share (1/(2 m)) times the overlap of two half cosines of 2 m frames, summed as above.
    const double m = std::ldexp(1.0, octave), step = mtf::kPi / (2.0 * m);
    double sum = n;
    for (int k = 1; k < frames && k < 2.0 * m; ++k) {
      const double shared =
          ((2.0 * m - k + 1.0) * std::cos(step * k) + std::sin(step * (k - 1.0)) / std::sin(step)) / (2.0 * m);
      sum += 2.0 * (n - k) * shared;
    }
    variance += parts.octaves[static_cast<std::size_t>(octave - 1)] * sum / (n * n);
  }
  return variance;
}

double frame_flicker_density(const FrameFlicker& noise, double f_cy_frame) {
  const Parts parts = parts_of(noise);
  double sum = parts.white;
  for (int octave = 1; octave <= std::ssize(parts.octaves); ++octave) {
    // Sum of cos(pi n / (2 m)) cos(2 pi f n) for n from -m to m, as two geometric sums.
    const double m = std::ldexp(1.0, octave);
    const auto half = [&](double shift) {  // sin(m x) cot(x / 2) for x = 2 pi f + shift, but for the sign
      const double x = 2.0 * mtf::kPi * f_cy_frame + shift;
      return std::sin(m * x) / std::tan(0.5 * x);
    };
    const double step = mtf::kPi / (2.0 * m), near = std::abs(2.0 * mtf::kPi * f_cy_frame - step);
    const double transform = near < 1e-9 * step ? m : 0.5 * (half(step) + half(-step));
    sum += parts.octaves[static_cast<std::size_t>(octave - 1)] * transform * transform / m;
  }
  return sum;
}

void add_frame_flicker(mtf::ImageView<float> image, const FrameFlicker& noise, const NoiseKey& key, Origin origin,
                       int threads, std::int64_t every) {
  const Parts parts = parts_of(noise);
  add_gaussian(image, std::sqrt(parts.white), key, stream_of(0), origin, threads, every);
  for (int octave = 1; octave <= std::ssize(parts.octaves); ++octave) {
    // Row 2^32 - 1 is beyond those from which numbers are taken.
    const std::uint32_t spacing = std::uint32_t{1} << octave;
    const std::uint32_t shift = RandomRow{{key.seed, 0}, stream_of(octave), 0xffffffffU}.pair(0)[0] & (spacing - 1);
    const std::uint32_t place = key.frame + shift, knot = place >> octave;
    const double turn = 0.5 * mtf::kPi * static_cast<double>(place & (spacing - 1)) / static_cast<double>(spacing);
    const double rms = std::sqrt(parts.octaves[static_cast<std::size_t>(octave - 1)]);
    add_gaussian(image, rms * std::cos(turn), {key.seed, knot}, stream_of(octave), origin, threads, every);
    add_gaussian(image, rms * std::sin(turn), {key.seed, knot + 1}, stream_of(octave), origin, threads, every);
  }
}

}  // namespace radiometry
