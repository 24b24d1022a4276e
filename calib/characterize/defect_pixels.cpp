// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/defect_pixels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/fit/fit_report.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;

constexpr double kFar_sd = 4.5;  // the limit, in standard deviations of the others
constexpr double kChance_p = 1e-3, kSure_sd = 3.0;

double far_share() { return 0.5 * std::erfc(kFar_sd / std::numbers::sqrt2); }
/// By how many standard deviations normal numbers beyond the limit exceed it on average.
double far_excess() {
  return std::exp(-0.5 * kFar_sd * kFar_sd) / std::sqrt(2.0 * std::numbers::pi) / far_share() - kFar_sd;
}

Finding share_finding(const char* name, double count, double pixels, const std::string& from) {
  const auto [low, high] = poisson_limits(count);
  return {.name = name,
          .unit = "",
          .verdict = count > 0.0 ? Verdict::determined : Verdict::upper_limit,
          .value = count / pixels,
          .sd = std::sqrt(count) / pixels,
          .low95 = low / pixels,
          .high95 = high / pixels,
          .from = from};
}

}  // namespace

DefectSums defect_sums(const Stack& stack, const PlaneSquares& dark, const PlaneSquares* response, double signal) {
  const mtf::Image& plane = stack.sums.pattern;
  const std::int64_t W = plane.width(), H = plane.height();
  enum Kind : char { good, beside, hot, dead, odd };
  std::vector<char> kind(static_cast<std::size_t>(plane.size()), good);
  const auto at = [&](std::int64_t x, std::int64_t y) -> char& { return kind[static_cast<std::size_t>(y * W + x)]; };
  DefectSums sums;
  std::vector<Defect> sources;
  if (response != nullptr)
    for (const Defect& d : response->defects) {
      const bool is_dead = d.excess < -0.5 * signal;
      at(d.x, d.y) = is_dead ? dead : odd;
      if (is_dead) sources.push_back(d);
    }
  for (const Defect& d : dark.defects) {
    char& one = at(d.x, d.y);
    if (one == dead) continue;
    one = d.excess > 0.0 ? hot : odd;
    if (one == hot) sums.hot.push_back(d);
  }
  sources.insert(sources.end(), sums.hot.begin(), sums.hot.end());
  for (const Defect& d : sources)
    for (std::int64_t y = std::max<std::int64_t>(0, d.y - 1); y < std::min(H, d.y + 2); ++y)
      for (std::int64_t x = std::max<std::int64_t>(0, d.x - 1); x < std::min(W, d.x + 2); ++x)
        if (at(x, y) == good || at(x, y) == odd) at(x, y) = beside;

  const auto pixels = static_cast<double>(plane.size());
  const NoiseScales& noise = stack.sums.noise;
  double of_good = 0.0, goods = 0.0, of_others = 0.0, others = 0.0, squares = 0.0, neighbours = 0.0, sum_beside = 0.0;
  for (std::int64_t y = 0; y < H; ++y)
    for (std::int64_t x = 0; x < W; ++x) {
      const char one = at(x, y);
      sums.dead += one == dead ? 1 : 0;
      sums.others += one == odd ? 1 : 0;
      neighbours += one == beside ? 1.0 : 0.0;
      if (one != good) (one == beside ? sum_beside : sums.mean) += dark.deviation(plane.view(), x, y);
      if (noise.empty() || y % noise.rows_apart != 0) continue;
      const double variance = noise.variance(static_cast<std::size_t>(y / noise.rows_apart * W + x));
      const bool counts = one == good || one == beside;
      (counts ? of_good : of_others) += variance;
      (counts ? goods : others) += 1.0;
      if (!counts) squares += variance * variance;
    }
  if (sum_beside > kSure_sd * std::sqrt(neighbours) * dark.far / kFar_sd) sums.mean += sum_beside;
  sums.mean /= pixels;
  if (others > 0.0 && goods > 0.0) {
    sums.variance = (of_others - others * of_good / goods) / (goods + others);
    sums.scatter = squares / (goods + others);
  }
  return sums;
}

void add_hot_pixels(const DefectSums& sums, const PlaneSquares& dark, const Estimate& gain, const std::string& from,
                    Characterization& camera) {
  const double pixels = dark.rows * dark.columns, F = dark.far, s = F / kFar_sd, chance = pixels * far_share();
  const auto count = static_cast<double>(sums.hot.size()), n = count - chance;
  const auto undetermined = [&](const std::string& why) {
    camera.findings.push_back(
        {.name = "hot_excess", .unit = "e-", .verdict = Verdict::not_determined, .from = from, .why = why});
  };
  if (!(poisson_tail(count, chance) < kChance_p)) {
    Finding none = share_finding("hot_fraction", std::max(0.0, n), pixels, from + ", beyond 4.5 sd");
    none.verdict = Verdict::upper_limit;
    none.value = none.low95 = 0.0;
    none.high95 = poisson_limits(count)[1] / pixels;
    camera.findings.push_back(none);
    return undetermined("no more pixels are hot than chance makes");
  }
  double sum = -chance * far_excess() * s, squares = 0.0;
  for (const Defect& d : sums.hot) sum += d.excess - F;
  const double m = sum / n;
  for (const Defect& d : sums.hot) squares += (d.excess - F - m) * (d.excess - F - m);
  if (!(m > s)) {
    camera.findings.push_back(share_finding("hot_fraction", n, pixels, from + ", beyond 4.5 sd"));
    camera.findings.back().verdict = Verdict::not_determined;
    camera.findings.back().why = "the pixels beyond 4.5 sd are not apart from the others; one rms describes them badly";
    return undetermined(camera.findings.back().why);
  }
  const double slope = F / m - s * s / (m * m), relative = std::sqrt((1.0 + slope * slope) / n);
  const double share = n / pixels * std::exp(F / m - 0.5 * s * s / (m * m)), of_gain = gain.sd / gain.value;
  const std::string how = from + ", " + std::to_string(sums.hot.size()) + " pixels beyond 4.5 sd";
  camera.findings.push_back({.name = "hot_fraction",
                             .unit = "",
                             .value = std::min(1.0, share),
                             .sd = share * relative,
                             .low95 = share * std::exp(-k95_sd * relative),
                             .high95 = std::min(1.0, share * std::exp(k95_sd * relative)),
                             .from = how});
  // n excesses of one mean are gamma distributed; the gain's error is small beside it.
  const auto [low, high] = poisson_limits(n);
  const double e = m / gain.value;
  camera.findings.push_back({.name = "hot_excess",
                             .unit = "e-",
                             .value = e,
                             .sd = e * std::hypot(1.0 / std::sqrt(n), of_gain),
                             .low95 = e * n / high,
                             .high95 = e * n / low,
                             .from = how});
  // The squared ratio of sd and mean is 1 for exponential numbers, with the standard deviation 2/sqrt(n) and a tail
  // above it.
  const double z = 0.5 * std::sqrt(n) * (squares / (n * m * m) - 1.0);
  if (z < -4.0 || z > 6.0)
    camera.warnings.push_back(from + ": the excesses of the " + std::to_string(sums.hot.size()) +
                              " hot pixels are not exponentially distributed (their sd is " +
                              significant(std::sqrt(squares / n) / m, 2) +
                              " of their mean, where 1 is), as those of the twin are; --maps gives each its own");
}

void add_dead_pixels(const DefectSums& sums, double pixels, const std::string& from, Characterization& camera) {
  camera.findings.push_back(share_finding("dead_fraction", static_cast<double>(sums.dead), pixels,
                                          from + ", response below half of that of the others"));
  const auto others = static_cast<double>(sums.others);
  if (poisson_tail(others, 3.0 * pixels * far_share()) < kChance_p)
    camera.warnings.push_back(from + ": " + std::to_string(sums.others) +
                              " pixels are beyond 4.5 sd, in the dark or in their response, and neither hot nor dead; "
                              "the twin has none of them; --maps gives each its own");
}

}  // namespace calib
