// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/veiling_glare.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "radiometry/light/pixel_rules.h"

namespace radiometry {
namespace {

/// Mean of the 2 reach + 1 values about each of `n`, those beyond the ends being `outside`. `sums` is scratch.
template <class Read, class Write>
void running_mean(std::int64_t n, std::int64_t reach, double outside, std::vector<double>& sums, Read read,
                  Write write) {
  sums.resize(static_cast<std::size_t>(n) + 1);
  sums[0] = 0.0;
  for (std::int64_t i = 0; i < n; ++i)
    sums[static_cast<std::size_t>(i + 1)] = sums[static_cast<std::size_t>(i)] + read(i) - outside;
  for (std::int64_t i = 0; i < n; ++i) {
    const auto from = static_cast<std::size_t>(std::max<std::int64_t>(i - reach, 0));
    const auto to = static_cast<std::size_t>(std::min(i + reach + 1, n));
    write(i, outside + (sums[to] - sums[from]) / static_cast<double>(2 * reach + 1));
  }
}

}  // namespace

double finite_mean(mtf::ImageView<const float> image) {
  double sum = 0.0;
  std::int64_t count = 0;
  for (std::int64_t y = 0; y < image.height; ++y) {
    const float* row = image.row(y);
    for (std::int64_t x = 0; x < image.width; ++x)
      if (std::isfinite(row[x])) {
        sum += static_cast<double>(row[x]);
        ++count;
      }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

void add_glare(mtf::ImageView<float> image, const VeilingGlare& glare, double mean, int threads) {
  require_valid("veiling_glare", glare);
  if (!std::isfinite(mean)) throw mtf::UsageError("veiling_glare: a mean of the image that is not finite");
  const double kept = 1.0 - glare.fraction, added = (glare.fraction + glare.offset) * mean;
  for_each_pixel(image, threads, [&](double value) { return static_cast<float>(kept * value + added); });
}

mtf::Image ghost_image(mtf::ImageView<const float> image, const Ghost& ghost, const FocalPlane& detector) {
  require_valid("ghost", ghost);
  require_region(detector, {}, detector.columns, detector.rows);
  if (image.width != detector.columns || image.height != detector.rows)
    throw mtf::UsageError("ghost: an image of " + size_of(image.width, image.height) + " pixels for a detector of " +
                          size_of(detector.columns, detector.rows) + "; the ghost needs the whole image");
  const double mean = finite_mean(image);
  // Column x mirrors column last + shift - x; the shift is twice the offset of the axis, to the nearest whole.
  const auto shift = [](double axis_um, double step_um) {
    return static_cast<std::int64_t>(std::llround(std::clamp(2.0 * axis_um / step_um, -1e15, 1e15)));
  };
  const std::int64_t last_x = image.width - 1 + shift(detector.axis_x_um, detector.step_x_um);
  const std::int64_t last_y = image.height - 1 + shift(detector.axis_y_um, detector.step_y_um);
  mtf::Image out(image.width, image.height);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const std::int64_t from_x = last_x - x, from_y = last_y - y;
      const bool inside = from_x >= 0 && from_x < image.width && from_y >= 0 && from_y < image.height;
      const bool known = inside && std::isfinite(image.at(from_x, from_y));
      out.at(x, y) = known ? image.at(from_x, from_y) : static_cast<float>(mean);
    }
  const auto reach = static_cast<std::int64_t>(std::floor(0.5 * ghost.width_px));
  if (reach == 0) return out;
  std::vector<double> sums;
  for (std::int64_t y = 0; y < out.height(); ++y)
    running_mean(
        out.width(), reach, mean, sums, [&](std::int64_t x) { return static_cast<double>(out.at(x, y)); },
        [&](std::int64_t x, double value) { out.at(x, y) = static_cast<float>(value); });
  for (std::int64_t x = 0; x < out.width(); ++x)
    running_mean(
        out.height(), reach, mean, sums, [&](std::int64_t y) { return static_cast<double>(out.at(x, y)); },
        [&](std::int64_t y, double value) { out.at(x, y) = static_cast<float>(value); });
  return out;
}

void add_ghost(mtf::ImageView<float> image, const Ghost& ghost, mtf::ImageView<const float> ghosts, int threads) {
  require_valid("ghost", ghost);
  if (image.width != ghosts.width || image.height != ghosts.height)
    throw mtf::UsageError("ghost: a ghost image of " + size_of(ghosts.width, ghosts.height) +
                          " pixels for an image of " + size_of(image.width, image.height) + "; give both one size");
  const double q = ghost.fraction;
  for_each_pixel(image, ghosts, threads,
                 [&](double value, double other) { return static_cast<float>((1.0 - q) * value + q * other); });
}

}  // namespace radiometry
