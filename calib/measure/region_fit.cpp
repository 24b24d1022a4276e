// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/region_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "calib/edge/median.h"
#include "mtf/work/stop.h"

namespace calib {
namespace {

// Hot and dead pixels, cosmic rays and the like: single pixels that differ from the others at the same distance from
// the edge by more than noise can. A pixel's residual is compared with the median of those at its distance, so that
// what all of them share (overshoot, a blur that the reference step does not describe) is never an outlier, and the
// size of the noise is the median absolute deviation, which the outliers themselves do not raise (P. J. Huber, Robust
// Statistics, 1981).

constexpr double kFar = 5.5;         // standard deviations: noise alone exceeds them once in 10^7 pixels
constexpr double kLeast = 0.02;      // of the contrast: what differs by less is left to the noise
constexpr double kMostShare = 0.02;  // of all pixels
constexpr double kCommon = 0.3;      // of the pixels at a distance: these belong to the response
constexpr double kPlateau = 0.08;

// The pixels in the order of their bins; those of bin k are first[k] .. first[k + 1] - 1. Pixels beyond the range are
// not listed.
struct ByBin {
  std::array<std::size_t, kBins + 1> first{};
  std::vector<std::size_t> pixel;
};
ByBin sort_by_bin(const PixelResiduals& pixels) {
  ByBin sorted;
  std::array<std::size_t, kBins + 1> next{};
  for (const std::int32_t bin : pixels.bin)
    if (bin < kBins) ++sorted.first[static_cast<std::size_t>(bin) + 1];
  for (std::size_t k = 0; k < kBins; ++k) sorted.first[k + 1] += sorted.first[k];
  next = sorted.first;
  sorted.pixel.resize(sorted.first[kBins]);
  for (std::size_t i = 0; i < pixels.bin.size(); ++i)
    if (pixels.bin[i] < kBins) sorted.pixel[next[static_cast<std::size_t>(pixels.bin[i])]++] = i;
  return sorted;
}

// Neighbouring bins with enough pixels for a median.
struct Window {
  std::size_t first, end;  // in ByBin::pixel
};
std::vector<Window> windows_of(const ByBin& sorted) {
  constexpr std::size_t kEnough = 16;
  std::vector<Window> windows;
  for (std::size_t k = 0; k < kBins; ++k) {
    const std::size_t end = sorted.first[k + 1];
    if (windows.empty() || windows.back().end - windows.back().first >= kEnough)
      windows.push_back({sorted.first[k], end});
    else
      windows.back().end = end;
  }
  if (windows.size() > 1 && windows.back().end - windows.back().first < kEnough) {
    const std::size_t end = windows.back().end;
    windows.pop_back();
    windows.back().end = end;
  }
  return windows;
}

// On the dark plateau, on the edge, on the bright plateau: noise differs between these.
std::size_t part_of(double esf) { return esf < kPlateau ? 0 : esf > 1.0 - kPlateau ? 2 : 1; }

/// Removes them; returns how many. More than 2 % of the pixels are structure: then none is removed.
std::size_t remove_outliers(EdgePixels& pixels, const EdgeModel& model, const FitState& state,
                            const Rounding& rounding) {
  const double least = std::max(kLeast * model.contrast(), 1.5 * std::max(rounding.dark, rounding.bright));
  // The noise of the fit, in which the outliers are still included, is a quick test.
  BinRow variance = variances(state.noise, state.profile);
  for (double& one : variance) one = std::max(one, least * least / (kFar * kFar));
  if (!(largest_deviation(pixels, model, state.profile, variance) > kFar)) return 0;

  PixelResiduals all = residuals_of(pixels, model, state.profile);
  const ByBin sorted = sort_by_bin(all);
  const std::vector<Window> windows = windows_of(sorted);
  std::array<std::vector<double>, 3> deviations;
  const auto part = [&](std::size_t i) { return part_of(state.profile.esf()[static_cast<std::size_t>(all.bin[i])]); };
  std::vector<double> values, middle;
  for (const auto& [first, end] : windows) {
    mtf::require_going_on();
    values.clear();
    for (std::size_t k = first; k < end; ++k) values.push_back(all.residual[sorted.pixel[k]]);
    middle.push_back(values.empty() ? 0.0 : median(values));
  }
  // A step far from the reference changes within a window too, by no more than to the medians beside it.
  for (std::size_t w = 0; w < windows.size(); ++w) {
    mtf::require_going_on();
    const auto [low, high] =
        std::minmax({middle[w > 0 ? w - 1 : w], middle[w], middle[std::min(w + 1, windows.size() - 1)]});
    for (std::size_t k = windows[w].first; k < windows[w].end; ++k) {
      const std::size_t i = sorted.pixel[k];
      const double residual = all.residual[i];
      deviations[part(i)].push_back(std::abs(residual - middle[w]));
      all.residual[i] = std::abs(residual - std::clamp(residual, low, high));
    }
  }
  std::array<double, 3> limit{};
  for (std::size_t p = 0; p < limit.size(); ++p)
    limit[p] = deviations[p].empty() ? INFINITY : std::max(least, kFar * median(deviations[p]) / 0.6745);

  std::vector<bool> far(pixels.size());
  std::size_t removed = 0;
  for (const auto& [first, end] : windows) {
    mtf::require_going_on();
    const auto is_far = [&](std::size_t i) { return all.residual[i] > limit[part(i)]; };
    std::size_t count = 0;
    for (std::size_t k = first; k < end; ++k) count += is_far(sorted.pixel[k]) ? 1 : 0;
    if (static_cast<double>(count) > kCommon * static_cast<double>(end - first)) continue;
    for (std::size_t k = first; k < end; ++k) far[sorted.pixel[k]] = is_far(sorted.pixel[k]);
    removed += count;
  }
  if (removed == 0 || static_cast<double>(removed) > kMostShare * static_cast<double>(pixels.size())) return 0;
  EdgePixels kept(pixels.size() - removed);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (!far[i]) kept.add(pixels.x()[i], pixels.y()[i], pixels.value()[i]);
  pixels = std::move(kept);
  return removed;
}

// The shape that the fit begins with: half of the Gaussian's variance as a footprint, some as diffraction.
void split_blur(ReferenceShape& shape) {
  const double variance = shape.v_px2;
  shape.q_px2 = std::min(1.0, 6.0 * variance);
  shape.v_px2 = std::max(2.0 * kLeastVariance_px2, variance - shape.q_px2 / 12.0);
  shape.s_px = 0.3 * std::sqrt(variance);
}

// From the state at a model near the best one to that at the best one, without diffraction where the pixels do not show
// it, before or after these iterations.
void converge(const EdgePixels& pixels, EdgeFit& fit, FitSettings settings) {
  settings.unknowns = fit.unknowns;
  settings.max_iterations = 8;
  settings.tolerance = 0.3;
  // Whether diffraction is left out.
  const auto judge_diffraction = [&] {
    fit.diffraction = diffraction_in(fit.state, fit.model, fit.unknowns);
    if (fit.diffraction != Diffraction::absent) return false;
    ReferenceShape& shape = fit.model.shape;
    const double s_px = std::exchange(shape.s_px, 0.0);
    shape.v_px2 += 0.1 * s_px * s_px;
    fit.unknowns.reset(kFirstShape);
    settings.unknowns = fit.unknowns;
    if (s_px > 0.0) fit.state = evaluate(pixels, fit.model, settings);
    return true;
  };
  const bool left_out = judge_diffraction();
  fit.state = fit_reference(pixels, fit.model, settings, std::move(fit.state));
  if (left_out || !judge_diffraction()) return;
  fit.state = fit_reference(pixels, fit.model, settings, std::move(fit.state));
}

// From the first model to the best reference step: first on a subset of the pixels, then on all.
EdgeFit fit_edge(const EdgePixels& pixels, EdgeModel start, FitSettings settings, const MeasureOptions& options,
                 double extent_px) {
  constexpr std::size_t kSome = 2000;
  const std::size_t step = step_for(pixels, kSome);
  EdgeFit fit{.model = std::move(start), .unknowns = basic_unknowns()};
  split_blur(fit.model.shape);
  const auto refine = [&](std::size_t every, int max_iterations, double tolerance) {
    settings.unknowns = fit.unknowns;
    settings.every = every;
    settings.max_iterations = max_iterations;
    settings.tolerance = tolerance;
    return fit_reference(pixels, fit.model, settings);
  };
  constexpr double kRough = 4.0;  // chi2: less than another subset of the pixels would change
  constexpr double kBent = 1.3;   // chi2
  const auto bend_by = [&](int order) {
    fit.unknowns = with_order(fit.unknowns, order);
    set_order(fit.model.curve, order, options.circle);
    return refine(step, 12, kRough);
  };
  // A bend is fitted to these pixels first if it explains most of their misfit.
  int order = 1;
  if (const FitState some = refine(step, 25, kRough);
      options.order != 1 && some.normal.chi2 > kBent * some.normal.count) {
    const EdgeFit straight = fit;
    const FitState bent = bend_by(2);
    const double misfit = bent.normal.chi2 * bent.noise.at(0.5) / some.noise.at(0.5);
    order = misfit < 0.5 * some.normal.chi2 ? 2 : 1;
    if (order == 1) fit = straight;
  }

  settings.every = 1;
  settings.unknowns = with_gradients(with_order(fit.unknowns, kHighestOrder));
  fit.state = evaluate(pixels, fit.model, settings);
  const Terms terms = choose_terms(fit.state, fit.model, extent_px, options, order);
  if (terms.gradients) fit.unknowns = with_gradients(fit.unknowns);
  if (terms.gradients || terms.order > order) {
    bend_by(terms.order);
    settings.every = 1;
    settings.unknowns = fit.unknowns;
    fit.state = evaluate(pixels, fit.model, settings);
  }
  converge(pixels, fit, settings);
  return fit;
}

// Adds the pixels whose noise is cut off and continues the fit with them. The noise, which lacks the cut tail at first,
// approaches its value by a factor of two or more a round.
void fit_cut(RegionFit& region) {
  constexpr int kMostRounds = 8;
  constexpr double kSame = 2e-3;  // relative change of the variances
  const CutPixels& limits = region.data.cut;
  EdgeFit& fit = region.fit;
  if (region.cut == 0) region.cut = add_cut(region.pixels, limits, fit.model, fit.state);
  if (region.cut == 0) return;
  FitSettings settings = region.settings;
  settings.unknowns = fit.unknowns;
  for (int round = 0; round < kMostRounds; ++round) {
    const NoiseModel before = fit.state.noise;
    expect_cut(region.pixels, limits, fit.model, fit.state);
    fit.state = fit_reference(region.pixels, fit.model, settings);
    const NoiseModel& after = fit.state.noise;
    if (std::abs(after.dark - before.dark) < kSame * after.dark &&
        std::abs(after.bright - before.bright) < kSame * after.bright)
      break;
  }
}

// What follows the fit of the pixels between the limits of the values, and its facts.
void finish(RegionFit& region) {
  const auto facts = [&] {
    return facts_of(region.pixels, region.fit.state, region.fit.model, region.data.local_noise_sd);
  };
  region.facts = facts();
  const bool rounds = region.settings.rounding.dark > 0.0 && region.settings.rounding.bright > 0.0;
  if (rounds && region.facts.few_distances()) {
    region.settings.few_distances = true;
    FitSettings settings = region.settings;
    settings.unknowns = region.fit.unknowns;
    region.fit.state = evaluate(region.pixels, region.fit.model, settings);
    converge(region.pixels, region.fit, settings);
    region.facts = facts();
  }
  if (region.data.cut.pixels.size() > 0) fit_cut(region);
  if (region.cut > 0) region.facts = facts();
  region.facts.unclear_diffraction = region.fit.diffraction == Diffraction::unclear;
  region.facts.neighbour_px =
      region.fit.unknowns[kFirstShape] ? region.data.neighbour_px : 0.0;  // its tail is proportional to S
  region.facts.outliers = region.outliers;
  region.facts.cut = region.cut;
  region.facts.clipped = region.data.cut.pixels.size() - region.cut;
  const NoiseCorrelation& noise = region.settings.correlation;
  for (const PixelLag& lag : noise.lags)
    if (std::max(std::abs(lag.x), std::abs(lag.y)) == 1)
      region.facts.shared_noise = std::max(region.facts.shared_noise, std::abs(lag.correlation));
  region.facts.stripes = std::sqrt(std::max(noise.columns, noise.rows));
}

}  // namespace

RegionFit fit_region(EdgeRegion data, const MeasureOptions& options) {
  RegionFit region{.data = std::move(data)};
  region.pixels = std::move(region.data.pixels);
  region.settings = region.data.settings;
  const auto fit = [&] {
    region.fit = fit_edge(region.pixels, region.data.start, region.settings, options, region.data.extent_px);
  };
  fit();
  // Outliers hide others from the first fit, and it moves towards them.
  constexpr int kMostRounds = 3;
  for (int round = 0; round < kMostRounds; ++round) {
    const std::size_t removed =
        remove_outliers(region.pixels, region.fit.model, region.fit.state, region.settings.rounding);
    if (removed == 0) break;
    region.outliers += removed;
    fit();
  }
  finish(region);
  return region;
}

void fit_again(RegionFit& region, const NoiseCorrelation& correlation, const MeasureOptions& options) {
  region.settings.correlation = correlation;
  region.fit = fit_edge(region.pixels, region.data.start, region.settings, options, region.data.extent_px);
  finish(region);
}

}  // namespace calib
