// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "mtf/tiles/tiles.h"

namespace mtf {
namespace {

constexpr std::int64_t kBlock = 64;
constexpr double kFewFlatBlocks = 0.3;
constexpr std::int64_t kWorthPlanning = std::int64_t{1} << 23;  // samples; below, planning costs more than it saves
constexpr double kWorthIt = 2.0;  // of the work of the whole image, whose planning takes three times as much
constexpr double kReading = 0.05, kCoarse = 0.3;          // work besides transforms, a sample of the scene
constexpr std::array<std::int64_t, 2> kSides{512, 1024};  // of a tile in samples

bool is_flat(ImageView<const float> plane, const Region& region) {
  const float first = plane.at(region.x, region.y);
  for (std::int64_t y = region.y; y < region.y + region.height; ++y)
    for (std::int64_t x = region.x; x < region.x + region.width; ++x)
      if (plane.at(x, y) != first) return false;
  return true;
}

// Share of the blocks that are flat in all planes. As a rule a few samples show that a block is not.
double flat_blocks(std::span<const ImageView<const float>> planes) {
  const std::int64_t columns = planes[0].width / kBlock, rows = planes[0].height / kBlock;
  std::int64_t flat = 0;
  for (std::int64_t j = 0; j < rows; ++j)
    for (std::int64_t i = 0; i < columns; ++i)
      flat += std::all_of(planes.begin(), planes.end(),
                          [&](const auto& plane) {
                            return is_flat(plane, {i * kBlock, j * kBlock, kBlock, kBlock});
                          })
                  ? 1
                  : 0;
  return static_cast<double>(flat) / static_cast<double>(std::max<std::int64_t>(1, columns * rows));
}

}  // namespace

double TiledSensorPlan::flat_share(std::span<const ImageView<const float>> scene, double border_value) const {
  if (report_.whole) return 0.0;
  std::int64_t flat = 0;
  for (std::int64_t index = 0; index < report_.count; ++index) {
    // The canvas is flat where its part within the scene is, and a constant border has the same value.
    const auto within = [](std::int64_t first, std::int64_t count, std::int64_t n) {
      const std::int64_t from = std::clamp<std::int64_t>(first, 0, n - 1);
      return std::pair{from, std::clamp<std::int64_t>(first + count, from + 1, n) - from};
    };
    const auto [x, width] = within(x_.first_sample(index % x_.count()), x_.canvas_samples(), in_.width);
    const auto [y, height] = within(y_.first_sample(index / x_.count()), y_.canvas_samples(), in_.height);
    const Region region{x, y, width, height};
    flat += std::all_of(scene.begin(), scene.end(),
                        [&](const ImageView<const float>& plane) {
                          const bool continued = border_ != Border::constant ||
                                                 plane.at(region.x, region.y) == static_cast<float>(border_value);
                          return continued && is_flat(plane, region);
                        })
                ? 1
                : 0;
  }
  return static_cast<double>(flat) / static_cast<double>(report_.count);
}

std::optional<TiledSensorPlan> worth_tiling(const System<double>& system, const SampleGrid& scene,
                                            std::span<const ImageView<const float>> planes, double border_value,
                                            const PlanOptions& options) {
  const double samples = static_cast<double>(scene.width) * static_cast<double>(scene.height);
  if (planes.empty() || samples < static_cast<double>(kWorthPlanning) || flat_blocks(planes) < kFewFlatBlocks)
    return std::nullopt;
  for (const std::int64_t side : kSides) {
    const double ratio = std::max(system.frame.pitch_x_um / scene.step_x_um, 1.0);
    TiledSensorPlan plan =
        compile_tiled(system, scene, options,
                      {.threads = options.threads,
                       .side = std::max<std::int64_t>(1, std::llround(static_cast<double>(side) / ratio))});
    if (plan.report().whole) return std::nullopt;
    const SampleGrid& canvas = plan.inner().presample.in();
    const double each = static_cast<double>(canvas.width) * static_cast<double>(canvas.height);
    const double busy = static_cast<double>(plan.report().count) * (1.0 - plan.flat_share(planes, border_value));
    const double work = busy * each / samples + kReading + (plan.report().every > 0 ? kCoarse : 0.0);
    if (work < kWorthIt) return plan;
  }
  return std::nullopt;
}

}  // namespace mtf
