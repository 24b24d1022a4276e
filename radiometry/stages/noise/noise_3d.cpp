// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/noise_3d.h"

#include <cmath>

#include "mtf/error.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/mean_squares.h"

namespace radiometry {
namespace {

double sum_of_squares(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum;
}

}  // namespace

double Noise3d::total() const { return std::sqrt(t * t + v * v + h * h + tv * tv + th * th + vh * vh + tvh * tvh); }

void add_noise_3d(mtf::ImageView<float> image, const Noise3d& noise, const NoiseKey& key, Origin origin, int threads) {
  require_valid("noise", noise);
  require_on_detector(origin, image.width, image.height);
  const NoiseKey fixed{key.seed, 0};
  if (noise.t > 0.0) {
    float number = 0.0F;
    gaussian_row({key, Stream::frame, 0}, 0, 1, &number);
    number *= static_cast<float>(noise.t);
    for (std::int64_t y = 0; y < image.height; ++y)
      for (std::int64_t x = 0; x < image.width; ++x) image.at(x, y) += number;
  }
  add_row_noise(image, noise.v, fixed, Stream::cube_v, origin);
  add_column_noise(image, noise.h, fixed, Stream::cube_h, origin);
  add_row_noise(image, noise.tv, key, Stream::cube_tv, origin);
  add_column_noise(image, noise.th, key, Stream::cube_th, origin);
  add_gaussian(image, noise.vh, fixed, Stream::fixed_pixel, origin, threads);
  add_gaussian(image, noise.tvh, key, Stream::temporal_pixel, origin, threads);
}

Noise3dEstimator::Noise3dEstimator(std::int64_t width, std::int64_t height) : width_(width), height_(height) {
  if (width < 2 || height < 2)
    throw mtf::UsageError("3-D noise of frames of " + size_of(width, height) +
                          " pixels; at least two columns and two rows are needed");
  pixel_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0);
}

void Noise3dEstimator::add(mtf::ImageView<const float> frame) {
  if (frame.width != width_ || frame.height != height_)
    throw mtf::UsageError("3-D noise: a frame of " + size_of(frame.width, frame.height) + " among frames of " +
                          size_of(width_, height_) + "; give all one size");
  double sum = 0.0;
  for (std::int64_t y = 0; y < height_; ++y)
    for (std::int64_t x = 0; x < width_; ++x) sum += static_cast<double>(frame.at(x, y));
  if (!std::isfinite(sum))
    throw mtf::UsageError("3-D noise: frame " + std::to_string(frame_.size()) +
                          " holds NaN or infinite pixels; fill them before");
  if (frame_.empty()) shift_ = sum / static_cast<double>(width_ * height_);
  std::vector<double> columns(static_cast<std::size_t>(width_), 0.0);
  double total = 0.0;
  std::size_t i = 0;
  for (std::int64_t y = 0; y < height_; ++y) {
    double row = 0.0;
    for (std::int64_t x = 0; x < width_; ++x, ++i) {
      const double value = static_cast<double>(frame.at(x, y)) - shift_;
      squares_ += value * value;
      pixel_[i] += value;
      columns[static_cast<std::size_t>(x)] += value;
      row += value;
    }
    row_squares_ += row * row;
    total += row;
  }
  column_squares_ += sum_of_squares(columns);
  frame_.push_back(total);
}

Noise3d Noise3dEstimator::variances() const {
  const auto T = static_cast<double>(frame_.size()), V = static_cast<double>(height_), H = static_cast<double>(width_);
  if (T < 2.0)
    throw mtf::UsageError("3-D noise of " + std::to_string(frame_.size()) + " frames; at least two are needed");
  std::vector<double> rows(static_cast<std::size_t>(height_), 0.0), columns(static_cast<std::size_t>(width_), 0.0);
  double total = 0.0;
  for (std::size_t i = 0; i < pixel_.size(); ++i) {
    rows[i / static_cast<std::size_t>(width_)] += pixel_[i];
    columns[i % static_cast<std::size_t>(width_)] += pixel_[i];
    total += pixel_[i];
  }
  const MeanSquares ms = mean_squares({.frames = T,
                                       .rows = V,
                                       .columns = H,
                                       .all = total * total / (T * V * H),
                                       .t = sum_of_squares(frame_) / (V * H),
                                       .v = sum_of_squares(rows) / (T * H),
                                       .h = sum_of_squares(columns) / (T * V),
                                       .tv = row_squares_ / H,
                                       .th = column_squares_ / V,
                                       .vh = sum_of_squares(pixel_) / T,
                                       .tvh = squares_});
  return {.t = ms.variance(kT),
          .v = ms.variance(kV),
          .h = ms.variance(kH),
          .tv = ms.variance(kTv),
          .th = ms.variance(kTh),
          .vh = ms.variance(kVh),
          .tvh = ms.variance(kTvh)};
}

Noise3d Noise3dEstimator::estimate() const {
  Noise3d sigma = variances();
  for (double* value : {&sigma.t, &sigma.v, &sigma.h, &sigma.tv, &sigma.th, &sigma.vh, &sigma.tvh})
    *value = *value > 0.0 ? std::sqrt(*value) : 0.0;
  return sigma;
}

}  // namespace radiometry
