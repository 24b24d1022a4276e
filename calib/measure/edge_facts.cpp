// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_facts.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <vector>

#include "calib/edge/median.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

// The smallest and the largest value, how many pixels have them and how far the next value is.
struct Ends {
  std::ptrdiff_t at_low = 0, at_high = 0;
  double low_step = 0.0, high_step = 0.0;
  double low = 0.0, high = 0.0;
};

MTFKIT_CLONES Ends ends_of(const double* values, std::size_t n) {
  constexpr std::size_t kLanes = 16;
  std::array<double, kLanes> low, high, above, below;
  std::array<std::int64_t, kLanes> at_low{}, at_high{};
  low.fill(INFINITY);
  high.fill(-INFINITY);
  const std::size_t whole = n / kLanes * kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      low[k] = values[i + k] < low[k] ? values[i + k] : low[k];
      high[k] = values[i + k] > high[k] ? values[i + k] : high[k];
    }
  double least = *std::min_element(low.begin(), low.end()), most = *std::max_element(high.begin(), high.end());
  for (std::size_t i = whole; i < n; ++i) least = std::min(least, values[i]), most = std::max(most, values[i]);
  above.fill(most);
  below.fill(least);
  const auto take = [&](std::size_t k, double value) {
    at_low[k] += value == least ? 1 : 0;
    at_high[k] += value == most ? 1 : 0;
    above[k] = value > least && value < above[k] ? value : above[k];
    below[k] = value < most && value > below[k] ? value : below[k];
  };
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) take(k, values[i + k]);
  for (std::size_t i = whole; i < n; ++i) take(0, values[i]);
  return {std::accumulate(at_low.begin(), at_low.end(), std::ptrdiff_t{0}),
          std::accumulate(at_high.begin(), at_high.end(), std::ptrdiff_t{0}),
          *std::min_element(above.begin(), above.end()) - least,
          most - *std::max_element(below.begin(), below.end()),
          least,
          most};
}

// Of two different values between the ends: of rounded values a step or more.
double least_difference(const EdgePixels& pixels, const Ends& ends) {
  std::vector<double> between;
  std::copy_if(pixels.value(), pixels.value() + pixels.size(), std::back_inserter(between),
               [&](double value) { return value > ends.low && value < ends.high; });
  std::sort(between.begin(), between.end());
  between.erase(std::unique(between.begin(), between.end()), between.end());
  double least = ends.high - ends.low;
  for (std::size_t i = 1; i < between.size(); ++i) least = std::min(least, between[i] - between[i - 1]);
  return least;
}

// Of the residuals at the edge about straight lines of an eighth of a pixel.
struct Scatter {
  double sum = 0.0, dof = 0.0;
  double variance() const { return sum / std::max(1.0, dof); }
};
Scatter scatter_on_edge(const FitState& state) {
  constexpr int kMerged = kFinest / 8;
  constexpr double kPlateau = 0.15;
  Scatter scatter;
  for (int first = 0; first + kMerged <= kBins; first += kMerged) {
    const double esf = state.profile.esf()[static_cast<std::size_t>(first)];
    if (esf < kPlateau || esf > 1.0 - kPlateau) continue;
    double n = 0.0, x = 0.0, xx = 0.0, r = 0.0, xr = 0.0, rr = 0.0;
    for (int k = 0; k < kMerged; ++k) {
      const auto bin = static_cast<std::size_t>(first + k);
      const double count = state.sums.moment(0)[bin], residual = state.sums.residual(0)[bin];
      n += count;
      x += k * count;
      xx += k * k * count;
      r += residual;
      xr += k * residual;
      rr += state.sums.square()[bin];
    }
    if (n < 3.0) continue;
    const double spread = xx - x * x / n, slope = spread > 0.0 ? (xr - x * r / n) / spread : 0.0;
    scatter.sum += std::max(0.0, rr - r * r / n - slope * slope * spread);
    scatter.dof += n - 2.0;
  }
  return scatter;
}

// Whether fewer values lie near one end than a step further from it; `sign` is 1 at the smallest.
bool ends_abruptly(const EdgePixels& pixels, double end, double sign, double step) {
  constexpr double kFewest = 8.0, kGradual = 1.5;
  double near = 0.0, further = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double away = sign * (pixels.value()[i] - end);
    near += away > 0.0 && away <= step ? 1.0 : 0.0;
    further += away > step && away <= 2.0 * step ? 1.0 : 0.0;
  }
  return further >= kFewest && near < kGradual * further;
}

}  // namespace

double structure_share(const EdgeFacts& facts) {
  const double seen = std::max(facts.plateau_sd, facts.noise_sd);
  const double excess = seen * seen - 1.5 * facts.local_noise_sd * facts.local_noise_sd;
  return std::sqrt(std::max(0.0, excess)) / std::clamp(facts.contrast, 1e-300, 1.0);
}

double local_noise(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts) {
  constexpr std::int64_t kPairs = 2000;
  std::vector<float> differences;
  const std::int64_t step = std::max<std::int64_t>(1, roi.width * roi.height / kPairs) | 1;
  for (const std::int64_t apart :
       {3, 4}) {  // farther than noise is correlated; a Bayer plane has data in every other column
    visit_some(roi, step, [&](std::int64_t x, std::int64_t y) {
      if (x + apart >= roi.x + roi.width) return;
      const auto difference = static_cast<float>(
          (static_cast<double>(image.at(x + apart, y)) - static_cast<double>(image.at(x, y))) / facts.scale);
      if (std::isfinite(difference)) differences.push_back(std::abs(difference));
    });
    if (differences.size() > 16) break;
  }
  if (differences.empty()) return 0.0;
  return static_cast<double>(nth_least(differences, differences.size() / 2)) / (0.6745 * std::sqrt(2.0));
}

EdgeFacts facts_of(const EdgePixels& pixels, const FitState& state, const EdgeModel& model, double local_noise_sd) {
  const DistanceBins& bins = DistanceBins::get();
  EdgeFacts facts{.length_px = 2.0 * model.curve.half_length_px, .local_noise_sd = local_noise_sd};
  facts.width_px = 1.0 / std::max(1e-3, state.profile.lsf()[kSideBins]);
  facts.contrast = model.contrast();
  facts.noise_sd = std::sqrt(state.noise.at(0.5));
  double dark = 0.0, bright = 0.0, plateau = 0.0, squares = 0.0;
  std::array<double, 2> side_error{}, side_dof{};
  for (int i = 0; i < kBins; ++i) {
    const double n = state.sums.count(i), d = bins.centre(i);
    (d < 0.0 ? dark : bright) += n;
    if (std::abs(d) < 2.0 * facts.width_px) continue;
    plateau += n;
    squares += state.sums.square()[static_cast<std::size_t>(i)];
    side_error[d < 0.0 ? 0 : 1] += state.sums.pure_error(i);
    side_dof[d < 0.0 ? 0 : 1] += std::max(0.0, n - 1.0);
  }
  const Ends ends = ends_of(pixels.value(), pixels.size());
  const double share = static_cast<double>(pixels.size()) / std::max(1.0, dark + bright);
  facts.extent_dark_px = share * dark / facts.length_px;
  facts.extent_bright_px = share * bright / facts.length_px;
  facts.plateau_sd = std::sqrt(squares / std::max(1.0, plateau));
  const double sides = dark * bright / std::max(1.0, dark + bright);
  facts.significance = facts.contrast / std::max(1e-300, facts.noise_sd) * std::sqrt(std::max(0.0, sides));
  const double a = side_error[0] / std::max(1.0, side_dof[0]), b = side_error[1] / std::max(1.0, side_dof[1]);
  const bool enough = std::min(side_dof[0], side_dof[1]) > 50.0;
  const double visible = 1e-5 * facts.contrast * facts.contrast;
  // A side whose noise is below the step between values has one or two of them though it is not clipped.
  const auto fine = [](double variance, double step) { return variance > 0.36 * step * step; };
  constexpr double kHeaped = 0.2;  // of a side's pixels
  facts.bright_is_flat = enough && a > visible && fine(a, ends.high_step) &&
                         (b < 1e-10 || static_cast<double>(ends.at_high) > kHeaped * bright);
  facts.dark_is_flat = enough && b > visible && fine(b, ends.low_step) &&
                       (a < 1e-10 || static_cast<double>(ends.at_low) > kHeaped * dark);
  constexpr int kHalf_px = 2, kPerPixel = 8, kMerged = kFinest / kPerPixel;
  int filled = 0;
  for (int k = -kHalf_px * kPerPixel; k < kHalf_px * kPerPixel; ++k) {
    double n = 0.0;
    for (int m = 0; m < kMerged; ++m) n += state.sums.count(kSideBins + k * kMerged + m);
    filled += n > 0.0;
  }
  facts.oversampling = static_cast<double>(filled) / (2.0 * kHalf_px);
  if (static_cast<double>(ends.at_low) > kHeaped * dark && static_cast<double>(ends.at_high) > kHeaped * bright) {
    constexpr double kFewestOnEdge = 10.0, kQuiet = 0.5, kStep = 0.05;
    const Scatter on_edge = scatter_on_edge(state);
    const double rounding = least_difference(pixels, ends);
    facts.both_are_flat = on_edge.dof >= kFewestOnEdge && on_edge.variance() > visible &&
                          std::max(a, b) < kQuiet * on_edge.variance() && fine(on_edge.variance(), rounding);
    const double step = kStep * facts.contrast;
    facts.ends_abruptly = !facts.few_distances() && rounding <= 0.25 * step &&
                          ends_abruptly(pixels, ends.low, 1.0, step) && ends_abruptly(pixels, ends.high, -1.0, step);
  }
  return facts;
}

}  // namespace calib
