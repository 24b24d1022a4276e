// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/edge_outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calib/edge/median.h"

namespace calib {
namespace {

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

}  // namespace

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
    values.clear();
    for (std::size_t k = first; k < end; ++k) values.push_back(all.residual[sorted.pixel[k]]);
    middle.push_back(values.empty() ? 0.0 : median(values));
  }
  // A step far from the reference changes within a window too, by no more than to the medians beside it.
  for (std::size_t w = 0; w < windows.size(); ++w) {
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

}  // namespace calib
