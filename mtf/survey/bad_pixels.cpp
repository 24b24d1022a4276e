// SPDX-License-Identifier: Apache-2.0
#include "mtf/survey/bad_pixels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mtf/error.h"

namespace mtf {
namespace {

// Sum and number of the finite pixels in each cell of one level of the pyramid.
struct Level {
  std::int64_t width = 0, height = 0;
  std::vector<double> sum, count;
  std::size_t index(std::int64_t x, std::int64_t y) const { return static_cast<std::size_t>(y * width + x); }
};

Level halve(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.sum.assign(static_cast<std::size_t>(coarse.width * coarse.height), 0.0);
  coarse.count = coarse.sum;
  for (std::int64_t y = 0; y < fine.height; ++y)
    for (std::int64_t x = 0; x < fine.width; ++x) {
      coarse.sum[coarse.index(x / 2, y / 2)] += fine.sum[fine.index(x, y)];
      coarse.count[coarse.index(x / 2, y / 2)] += fine.count[fine.index(x, y)];
    }
  return coarse;
}

Level first_level(ImageView<float> image) {
  Level level{(image.width + 1) / 2, (image.height + 1) / 2, {}, {}};
  level.sum.assign(static_cast<std::size_t>(level.width * level.height), 0.0);
  level.count = level.sum;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      if (const double v = image.at(x, y); std::isfinite(v)) {
        level.sum[level.index(x / 2, y / 2)] += v;
        level.count[level.index(x / 2, y / 2)] += 1.0;
      }
  return level;
}

// The pixel that holds the centre of a sample, along one axis.
std::int64_t pixel_of(std::int64_t sample, double step, double pitch) {
  return static_cast<std::int64_t>(std::floor((static_cast<double>(sample) + 0.5) * step / pitch));
}

struct Box {
  std::int64_t x = 0, y = 0;  // half sizes in pixels
};

// Where the response to one sample in the middle exceeds the tolerance. A sample may lie anywhere in its pixel: when
// there are several to a pixel the box grows by one.
Box response_box(const Plan& plan, double tolerance, int threads) {
  const SampleGrid &in = plan.in(), &out = plan.out();
  Image impulse(in.width, in.height), response(out.width, out.height);
  std::fill_n(impulse.data(), impulse.size(), 0.0F);
  const std::int64_t x = std::min(
      in.width / 2, static_cast<std::int64_t>(0.5 * static_cast<double>(out.width) * out.step_x_um / in.step_x_um));
  const std::int64_t y = std::min(
      in.height / 2, static_cast<std::int64_t>(0.5 * static_cast<double>(out.height) * out.step_y_um / in.step_y_um));
  impulse.at(x, y) = 1.0F;
  plan.run(impulse.view(), response.view(), 0.0, threads);
  const std::int64_t cx = pixel_of(x, in.step_x_um, out.step_x_um), cy = pixel_of(y, in.step_y_um, out.step_y_um);
  Box box;
  for (std::int64_t j = 0; j < out.height; ++j)
    for (std::int64_t i = 0; i < out.width; ++i)
      if (std::abs(static_cast<double>(response.at(i, j))) > tolerance)
        box = {std::max(box.x, std::abs(i - cx)), std::max(box.y, std::abs(j - cy))};
  return {box.x + (in.step_x_um < out.step_x_um ? 1 : 0), box.y + (in.step_y_um < out.step_y_um ? 1 : 0)};
}

// Marks what lies within `half` of a mark, along one line of n samples `stride` apart.
void widen(float* line, std::int64_t n, std::int64_t stride, std::int64_t half) {
  std::vector<std::int64_t> marks(static_cast<std::size_t>(n) + 1, 0);
  for (std::int64_t i = 0; i < n; ++i)
    marks[static_cast<std::size_t>(i) + 1] = marks[static_cast<std::size_t>(i)] + (line[i * stride] != 0.0F ? 1 : 0);
  for (std::int64_t i = 0; i < n; ++i) {
    const auto from = static_cast<std::size_t>(std::max<std::int64_t>(0, i - half));
    const auto to = static_cast<std::size_t>(std::min(n, i + half + 1));
    line[i * stride] = marks[to] > marks[from] ? 1.0F : 0.0F;
  }
}

// Output pixels of `plan` that the marked input samples affect: 0 or 1. A periodic scene goes on beyond its edges.
Image affected_by(const Plan& plan, const Image& mask, double tolerance, int threads, bool periodic) {
  const SampleGrid &in = plan.in(), &out = plan.out();
  const Box box = response_box(plan, tolerance, threads);
  Image affected(out.width, out.height);
  std::fill_n(affected.data(), affected.size(), 0.0F);
  const auto mark = [&](std::int64_t x, std::int64_t y) {
    const std::int64_t column = pixel_of(x, in.step_x_um, out.step_x_um);
    const std::int64_t row = pixel_of(y, in.step_y_um, out.step_y_um);
    if (column < -box.x || row < -box.y || column >= out.width + box.x || row >= out.height + box.y) return;
    affected.at(std::clamp<std::int64_t>(column, 0, out.width - 1), std::clamp<std::int64_t>(row, 0, out.height - 1)) =
        1.0F;
  };
  const std::int64_t turns = periodic ? 1 : 0;
  for (std::int64_t y = 0; y < in.height; ++y)
    for (std::int64_t x = 0; x < in.width; ++x) {
      if (mask.at(x, y) == 0.0F) continue;
      for (std::int64_t j = -turns; j <= turns; ++j)
        for (std::int64_t i = -turns; i <= turns; ++i) mark(x + i * in.width, y + j * in.height);
    }
  for (std::int64_t y = 0; y < out.height; ++y) widen(affected.data() + y * out.width, out.width, 1, box.x);
  for (std::int64_t x = 0; x < out.width; ++x) widen(affected.data() + x, out.height, out.width, box.y);
  return affected;
}

}  // namespace

std::int64_t fill_bad_pixels(ImageView<float> image) {
  std::vector<Level> levels;
  std::int64_t replaced = 0;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      if (std::isfinite(image.at(x, y))) continue;
      if (levels.empty()) {
        levels.push_back(first_level(image));
        while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halve(levels.back()));
        if (levels.back().count.front() == 0.0) throw RuntimeError("no pixel is finite; nothing to fill from");
      }
      std::int64_t cx = x / 2, cy = y / 2;
      std::size_t l = 0;
      for (; levels[l].count[levels[l].index(cx, cy)] == 0.0; ++l) cx /= 2, cy /= 2;
      image.at(x, y) =
          static_cast<float>(levels[l].sum[levels[l].index(cx, cy)] / levels[l].count[levels[l].index(cx, cy)]);
      ++replaced;
    }
  return replaced;
}

Image bad_pixel_mask(ImageView<const float> image) {
  Image mask(image.width, image.height);
  bool any = false;
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const bool bad = !std::isfinite(image.at(x, y));
      mask.at(x, y) = bad ? 1.0F : 0.0F;
      any = any || bad;
    }
  return any ? std::move(mask) : Image();
}

void propagate_bad_pixels(const SensorPlan& plan, const Image& mask, double tolerance, int threads,
                          ImageView<float> image) {
  const bool periodic = plan.options.border == Border::periodic;
  Image bad = affected_by(plan.presample, mask, tolerance, threads, periodic);
  for (const std::optional<Plan>* filter : {&plan.readout, &plan.post})
    if (*filter) bad = affected_by(**filter, bad, tolerance, threads, periodic);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      if (bad.at(x, y) != 0.0F) image.at(x, y) = std::numeric_limits<float>::quiet_NaN();
}

}  // namespace mtf
