// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tile_halo.h"

#include <algorithm>
#include <cmath>

#include "mtf/plan/padding.h"
#include "mtf/plan/plan_parts.h"

namespace mtf {
namespace {

constexpr std::int64_t kShortestCanvas = 1024, kLongestCanvas = 16384;
constexpr double kFloatRounding = 3e-8;  // rms rounding of an OTF value, and four times that in the noise of a kernel

}  // namespace

std::optional<TileHalo> find_halo(const System<double>& system, std::span<const Stage> stages,
                                  const PlanOptions& options, const HaloRequest& request) {
  const double fx = 500.0 / request.in.step_x_um, fy = 500.0 / request.in.step_y_um;
  const double alias = std::sqrt(samples_per_pixel(request.in, request.out));
  const double density = std::sqrt(
      std::max(1.0, request.out.step_x_um / request.in.step_x_um * (request.out.step_y_um / request.in.step_y_um)));
  const double share = options.tolerance / (alias * request.norm);
  const std::int64_t length = next_smooth(std::clamp(4 * request.longest, kShortestCanvas, kLongestCanvas));
  const FactoredOtf sampler(system, stages, options.aperture,
                            {.fx_max = fx,
                             .fy_max = fy,
                             .drop_budget = kDropShare * share,
                             .table_share = kTableShare * share,
                             .samples = 9 * length,
                             .threads = options.threads,
                             .split = request.split,
                             .progress = options.progress});
  TileHalo halo;
  for (const Axis axis : {Axis::x, Axis::y}) {
    const bool x = axis == Axis::x;
    const CanvasRequest along{axis,
                              options.border,
                              x ? request.in.width : request.in.height,
                              x ? request.in.step_x_um : request.in.step_y_um,
                              x ? fy : fx,
                              x ? request.out.step_x_um : request.out.step_y_um,
                              request.norm * density,
                              0.5 * request.budget};
    const double noise = 4.0 * kFloatRounding * sampler.gain() / std::sqrt(static_cast<double>(length));
    const std::vector<double> tails = kernel_tails(sampler, along, length, noise);
    const std::int64_t most = std::min<std::int64_t>(request.longest, length / 4);
    std::int64_t d = 0;
    while (d <= most && along.norm * tails[static_cast<std::size_t>(d)] > along.budget) ++d;
    if (d > most) return std::nullopt;
    halo.samples[x ? 0 : 1] = d + 1;  // a pixel's centre may lie half a sample nearer to the edge
    halo.bound += along.norm * tails[static_cast<std::size_t>(d)];
  }
  return halo;
}

}  // namespace mtf
