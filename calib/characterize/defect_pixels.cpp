// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/defect_pixels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "calib/fit/fit_report.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;

constexpr double kFar_sd = 4.5;  // the limit, in standard deviations of the others
constexpr double kChance_p = 1e-3;

double far_share() { return 0.5 * std::erfc(kFar_sd / std::numbers::sqrt2); }
/// By how many standard deviations normal numbers beyond the limit exceed it on average.
double far_excess() {
  return std::exp(-0.5 * kFar_sd * kFar_sd) / std::sqrt(2.0 * std::numbers::pi) / far_share() - kFar_sd;
}

}  // namespace

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

DefectSums defect_sums(const NoiseScales& noise, const PlaneSquares& dark, const PlaneSquares* response,
                       double signal) {
  const double pixels = dark.rows * dark.columns;
  const auto columns = static_cast<std::int64_t>(dark.columns);
  DefectSums sums;
  std::set<std::int64_t> dead, seen;
  double variance = 0.0, looked_at = 0.0;
  const auto see = [&](const Defect& d) {
    const bool first = seen.insert(d.y * columns + d.x).second;
    if (!first || noise.empty() || d.y % noise.rows_apart != 0) return first;
    const double one = noise.variance(static_cast<std::size_t>(d.y / noise.rows_apart * columns + d.x));
    variance += one;
    sums.scatter += one * one;
    looked_at += 1.0;
    return first;
  };
  if (response != nullptr)
    for (const Defect& d : response->defects)
      if (d.excess < -0.5 * signal) dead.insert(d.y * columns + d.x), see(d);
  sums.dead = std::ssize(dead);
  for (const Defect& d : dark.defects) {
    sums.mean += d.excess / pixels;
    if (!see(d)) continue;
    if (d.excess > 0.0)
      sums.hot.push_back(d);
    else
      ++sums.others;
  }
  if (response != nullptr)
    for (const Defect& d : response->defects) sums.others += see(d) ? 1 : 0;
  if (!(looked_at > 0.0)) return sums;
  const auto all = static_cast<double>(noise.pixel_count());
  double of_all = 0.0;
  for (std::size_t i = 0; i < noise.pixel_count(); ++i) of_all += noise.variance(i);
  sums.variance = (variance - looked_at * (of_all - variance) / (all - looked_at)) / all;
  sums.scatter /= all;
  return sums;
}

bool exposures_differ(const std::vector<Stack>& stacks) {
  const auto [least, most] = std::ranges::minmax_element(stacks, {}, [](const Stack& stack) { return stack.time_s; });
  return !stacks.empty() && most->time_s > 1.01 * least->time_s;
}

void take_back_leaks(mtf::Image& plane, const std::vector<Defect>& defects, double side, double corner) {
  const double kept = 1.0 - 4.0 * (side + corner);
  for (const Defect& d : defects)
    for (std::int64_t y = std::max<std::int64_t>(0, d.y - 1); y < std::min(plane.height(), d.y + 2); ++y)
      for (std::int64_t x = std::max<std::int64_t>(0, d.x - 1); x < std::min(plane.width(), d.x + 2); ++x) {
        const std::int64_t away = std::abs(y - d.y) + std::abs(x - d.x);
        if (away > 0) plane.at(x, y) -= static_cast<float>((away == 1 ? side : corner) / kept * d.excess);
      }
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
