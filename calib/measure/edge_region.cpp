// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_region.h"

#include <algorithm>
#include <cmath>

#include "calib/measure/defects/neighbours.h"
#include "calib/measure/edge_facts.h"
#include "calib/measure/edge_start.h"
#include "calib/measure/edge_terms.h"

namespace calib {
namespace {

// The step between neighbouring values of the image where the pixels' (scaled) value is this, in the pixels' unit.
double step_at(double value, const RegionFacts& region, const MeasureOptions& options) {
  const double step = options.quantum_at ? options.quantum_at(region.offset + region.scale * value) : options.quantum;
  return std::isfinite(step) ? std::max(0.0, step) / region.scale : 0.0;
}

// Noise and rounding of the pixels, as far as they are known before a fit.
FitSettings noise_settings(const EdgeModel& start, const RegionFacts& region, const MeasureOptions& options) {
  FitSettings settings;
  settings.rounding = {step_at(start.plateau[0], region, options), step_at(start.plateau[1], region, options)};
  if (!options.noise_sd) return settings;
  constexpr double kMost = 1e3;  // of the range of values: under such noise no edge is seen
  const double sd = std::min(*options.noise_sd / region.scale, kMost);
  const double step = std::max(settings.rounding.dark, settings.rounding.bright);
  settings.variance = std::max({settings.least_variance, step * step / 12.0, sd * sd});
  return settings;
}

// Block means of a large region give the place of the edge to a fraction of a block only: a Gaussian step whose blur
// begins as wide as that is fitted to the pixels.
void sharpen_start(const EdgePixels& pixels, EdgeModel& start, double block_px, FitSettings settings) {
  constexpr std::size_t kSome = 6000;
  start.shape.v_px2 = std::min(0.1 * block_px * block_px, 200.0);
  settings.unknowns = basic_unknowns();
  settings.unknowns.reset(kFirstShape).reset(kFirstShape + 2);
  settings.max_iterations = 40;
  settings.tolerance = 3.0;
  settings.every = step_for(pixels, kSome);
  settings.least_variance = std::max(settings.least_variance, 1e-4);
  fit_reference(pixels, start, settings);
}

}  // namespace

std::optional<EdgeRegion> gather_edge(mtf::ImageView<const float> image, const Roi& roi, RegionFacts& region,
                                      const MeasureOptions& options) {
  constexpr std::int64_t kFineBlocks_px = 4;
  const double local_noise_sd = local_noise(image, roi, region);
  const auto [limits, heaped] = find_limits(image, roi, region, options, region.scale * local_noise_sd);
  region.clipped += heaped;
  std::int64_t block_px = 1;
  const EdgePixels blocks = gather_blocks(image, roi, region, limits, block_px);
  const auto block = static_cast<double>(block_px);
  EdgeModel start = start_edge(blocks, block, static_cast<double>(roi.width), static_cast<double>(roi.height));
  if (!(start.curve.half_length_px > 0.0)) return std::nullopt;
  EdgePixels pixels = gather_pixels(image, roi, region, limits, start.curve, kRange_px);
  FitSettings settings = noise_settings(start, region, options);
  const double extent_px = 0.5 * static_cast<double>(pixels.size()) / (2.0 * start.curve.half_length_px);
  if (block_px > kFineBlocks_px) sharpen_start(pixels, start, block, settings);
  const Neighbours neighbours = find_neighbours(image, roi, region, start);
  settings.tails = neighbours.tails;
  CutPixels cut;
  if (region.clipped > 0) cut = gather_cut(image, roi, region, limits, start.curve, kRange_px, settings.rounding);
  return EdgeRegion{.pixels = std::move(pixels),
                    .cut = std::move(cut),
                    .start = std::move(start),
                    .extent_px = extent_px,
                    .local_noise_sd = local_noise_sd,
                    .settings = settings,
                    .neighbour_px = neighbours.nearest_px};
}

}  // namespace calib
