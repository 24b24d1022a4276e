// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/defect_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

double squared(double x) { return x * x; }

/// Numbers beyond a limit of an exponential distribution, with the rms error of each.
struct ExponentialTail {
  double n = 0.0, sum = 0.0, squares = 0.0;  ///< of what they have beyond it, and about the mean of that
  double limit = 0.0, scatter = 0.0;

  double mean() const { return sum / n; }
  /// The squared ratio of sd and mean is 1, with the standard deviation 2/sqrt(n) and a tail above it.
  bool is_exponential() const {
    const double z = 0.5 * std::sqrt(n) * (squares / (n * mean() * mean()) - 1.0);
    return z >= -4.0 && z <= 6.0;
  }
};

/// The part of some pixels that is seen, and its limits.
struct SeenPart {
  double value = 1.0, sd = 0.0, least = 1.0, most = 1.0;
};

/// NAME_fraction of the pixels, and NAME_excess.
void add_exponential(const std::string& name, const ExponentialTail& tail, double pixels, const SeenPart& seen,
                     const Estimate& gain, const std::string& unit, const std::string& from, Characterization& camera) {
  const double m = tail.mean(), n = tail.n, F = tail.limit, s = tail.scatter;
  const double slope = F / m - s * s / (m * m), relative = std::sqrt((1.0 + slope * slope) / n);
  const double share = n / pixels * std::exp(F / m - 0.5 * s * s / (m * m)) / seen.value;
  const auto away = [&](double part) { return std::hypot(k95_sd * relative, std::log(part / seen.value)); };
  camera.findings.push_back({.name = name + "_fraction",
                             .unit = "",
                             .value = std::min(1.0, share),
                             .sd = share * std::hypot(relative, seen.sd / seen.value),
                             .low95 = share * std::exp(-away(seen.most)),
                             .high95 = std::min(1.0, share * std::exp(away(seen.least))),
                             .from = from});
  // n excesses of one mean are gamma distributed, the gain is normal.
  const auto [low, high] = poisson_limits(n);
  const double e = m / gain.value, by_gain = k95_sd * gain.sd / gain.value;
  camera.findings.push_back({.name = name + "_excess",
                             .unit = unit,
                             .value = e,
                             .sd = e * std::hypot(1.0 / std::sqrt(n), gain.sd / gain.value),
                             .low95 = e * std::exp(-std::hypot(std::log(high / n), by_gain)),
                             .high95 = e * std::exp(std::hypot(std::log(n / low), by_gain)),
                             .from = from});
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

DefectSums defect_sums(const PlaneSquares& dark, const PlaneSquares* response, double signal,
                       const std::set<std::int64_t>& restless, bool lit) {
  const auto columns = static_cast<std::int64_t>(dark.columns);
  const auto place_of = [&](const Defect& d) { return d.y * columns + d.x; };
  DefectSums sums;
  std::set<std::int64_t> dead, not_hot;
  if (response != nullptr)
    for (const Defect& d : response->defects) {
      if (d.excess < -0.5 * signal) dead.insert(place_of(d));
      if (lit) not_hot.insert(place_of(d));
    }
  sums.dead = std::ssize(dead);
  const auto see = [&](const Defect& d, bool hot) {
    const std::int64_t place = place_of(d);
    if (dead.contains(place) || !sums.with_noise.insert(place).second || restless.contains(place)) return;
    if (hot)
      sums.hot.push_back(d);
    else
      ++sums.others;
  };
  for (const Defect& d : dark.defects) {
    sums.mean += d.excess / (dark.rows * dark.columns);
    see(d, d.excess > 0.0 && !not_hot.contains(place_of(d)));
  }
  if (response != nullptr)
    for (const Defect& d : response->defects) see(d, false);
  return sums;
}

double BlinkingPixels::explained() const {
  if (!known) return 0.0;
  const double rest = noisy - static_cast<double>(restless.size()), n = static_cast<double>(noise.pixels.size());
  if (!found()) return rest;
  double above = 0.0;  // of those below the limit all may be noisy
  for (const BlinkingPixel& pixel : noise.pixels) above += (pixel.excess - noise.least) / n;
  return rest + n * std::exp(noise.least / above) * all / looked_at;
}

double BlinkingPixels::squares() const {
  double sum = 0.0;
  for (const BlinkingPixel& pixel : noise.pixels) sum += squared(pixel.excess);
  return sum;
}

double BlinkingPixels::unseen_variance(double n) const {
  if (!found()) return 0.0;
  return squares() * (1.0 / noise.seen - 1.0) / looked_at * (0.25 - noise.share_variance(n)) * n / (n - 1.0);
}

double BlinkingPixels::unseen_mean() const {
  double sum = 0.0;
  for (const BlinkingPixel& pixel : noise.pixels) sum += pixel.excess;
  return found() ? 0.5 * sum * (1.0 / noise.seen - 1.0) / looked_at : 0.0;
}

double BlinkingPixels::slowness() const {
  const double r2 = squared(std::max(0.0, 1.0 - 2.0 * noise.change.value));
  return found() ? std::sqrt((1.0 + r2) / (1.0 - r2)) : 1.0;
}

double BlinkingPixels::mean_variance(double n, double pixels) const {
  if (!found()) return 0.0;
  return squares() / noise.seen * noise.share_variance(n) / (looked_at * pixels);
}

BlinkingPixels blinking_pixels(const StackSummary& dark, const PlaneSquares& plane, double shot, double side) {
  const auto columns = static_cast<std::int64_t>(dark.squares.columns);
  const std::vector<std::int64_t> noisy = noisy_places(dark);
  const auto pixels = static_cast<double>(dark.variances.size());
  BlinkingPixels found{.noise = {.frames = dark.frames},
                       .noisy = static_cast<double>(noisy.size()),
                       .looked_at = pixels,
                       .all = pixels,
                       .known = dark.frames >= kBlinkFrames && (noisy.empty() || dark.series.frames == dark.frames)};
  if (!found.known) return found;
  if (dark.series.places.size() < noisy.size() && !dark.series.places.empty()) {
    const std::int64_t last = dark.series.places.back();
    found.looked_at = static_cast<double>(last / columns / dark.rows_apart * columns + last % columns + 1);
  }
  const double white = typical_variance(dark),
               most = kAlikeNoise * f_quantile(1.0 - kAlike_p, dark.squares.frames - 1.0, 1e9);
  for (const std::int64_t place : noisy) {
    const double signal = plane.deviation(dark.pattern.view(), place % columns, place / columns);
    if (variance_at(dark, place) > most * (white + shot * std::max(0.0, signal))) found.restless.insert(place);
  }
  if (noisy.empty()) {  // nothing was read twice
    found.noise = estimate_blinking({.frames = dark.frames}, white, shot);
    return found;
  }
  found.noise = estimate_blinking(dark.series, white, shot);
  if (!(side > 0.0)) return found;
  std::map<std::int64_t, double> excess;
  for (const BlinkingPixel& pixel : found.noise.pixels) excess[pixel.place] = pixel.excess;
  std::erase_if(found.noise.pixels, [&](const BlinkingPixel& pixel) {
    return std::ranges::any_of(std::array{-columns, -std::int64_t{1}, std::int64_t{1}, columns},
                               [&](std::int64_t away) {
                                 const auto there = excess.find(pixel.place + away);
                                 return there != excess.end() && pixel.excess < 3.0 * side * there->second;
                               });
  });
  return found;
}

std::vector<std::int64_t> noisy_for_light(const Stack& stack, const Stack& dark, const Stack& bright,
                                          const PlaneSquares& plane, double shot) {
  const double signal = bright.sums.mean - dark.sums.mean, above = stack.sums.mean - dark.sums.mean;
  const double white = typical_variance(dark.sums);
  return noisy_places(stack.sums, [&](std::int64_t place) {
    const auto in = [&](const Stack& one) { return static_cast<double>(one.sums.pattern.data()[place]); };
    const std::int64_t columns = dark.sums.pattern.width();
    const double hot = plane.deviation(dark.sums.pattern.view(), place % columns, place / columns);
    const double light = above * (1.0 + in(bright) / signal - in(dark) / signal);
    return white + shot * std::max(0.0, light + (hot > plane.far ? hot : 0.0));
  });
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

void add_hot_pixels(const DefectSums& sums, const PlaneSquares& dark, const Estimate& gain, const std::string& unit,
                    const std::string& from, Characterization& camera) {
  const double pixels = dark.rows * dark.columns, F = dark.far, s = F / kFar_sd, chance = pixels * far_share();
  const auto count = static_cast<double>(sums.hot.size()), n = count - chance;
  const auto undetermined = [&](const std::string& why) {
    camera.findings.push_back(
        {.name = "hot_excess", .unit = unit, .verdict = Verdict::not_determined, .from = from, .why = why});
  };
  if (!(poisson_tail(count, chance) < kChance_p)) {
    Finding none = share_finding("hot_fraction", std::max(0.0, n), pixels, from + ", beyond 4.5 sd");
    none.verdict = Verdict::upper_limit;
    none.value = none.low95 = 0.0;
    none.high95 = poisson_limits(count)[1] / pixels;
    camera.findings.push_back(none);
    return undetermined("no more pixels are hot than chance makes");
  }
  ExponentialTail tail{.n = n, .sum = -chance * far_excess() * s, .limit = F, .scatter = s};
  for (const Defect& d : sums.hot) tail.sum += d.excess - F;
  if (!(tail.mean() > s)) {
    camera.findings.push_back(share_finding("hot_fraction", n, pixels, from + ", beyond 4.5 sd"));
    camera.findings.back().verdict = Verdict::not_determined;
    camera.findings.back().why = "the pixels beyond 4.5 sd are not apart from the others; one rms describes them badly";
    return undetermined(camera.findings.back().why);
  }
  for (const Defect& d : sums.hot) tail.squares += squared(d.excess - F - tail.mean());
  add_exponential("hot", tail, pixels, {}, gain, unit,
                  from + ", " + std::to_string(sums.hot.size()) + " pixels beyond 4.5 sd", camera);
  if (!tail.is_exponential())
    camera.warnings.push_back(from + ": the excesses of the " + std::to_string(sums.hot.size()) +
                              " hot pixels are not exponentially distributed (their sd is " +
                              significant(std::sqrt(tail.squares / n) / tail.mean(), 2) +
                              " of their mean, where 1 is), as those of the twin are; --maps gives each its own");
}

void add_blinking_pixels(const BlinkingPixels& blinking, const Estimate& gain, const std::string& unit,
                         const std::string& from, Characterization& camera) {
  const BlinkingNoise& noise = blinking.noise;
  const auto n = static_cast<double>(noise.pixels.size());
  const auto undetermined = [&](const char* name, const std::string& of, const std::string& why) {
    camera.findings.push_back({.name = name, .unit = of, .verdict = Verdict::not_determined, .from = from, .why = why});
  };
  if (!blinking.known)
    return undetermined("blinking_fraction", "",
                        noise.frames == 0 ? "it takes a level with light"
                        : noise.frames < kBlinkFrames
                            ? "it takes a stack of " + std::to_string(kBlinkFrames) + " frames or more"
                            : "the frames were not read a second time, for the values of the noisy pixels");
  const std::string how = from + ", " + std::to_string(noise.pixels.size()) + " pixels with two levels more than " +
                          significant(noise.least / gain.value, 3) + " " + unit + " apart";
  if (n == 0.0) {
    camera.findings.push_back(share_finding("blinking_fraction", 0.0, blinking.looked_at, how));
    return;
  }
  if (!blinking.found())
    return undetermined(
        "blinking_fraction", "",
        std::to_string(noise.pixels.size()) + " pixels blink, too few, or too slowly, to tell the part of all");
  if (blinking.unseen_count)
    camera.warnings.push_back(from + ": of the pixels that blink about " + significant(100.0 * (1.0 - noise.seen), 2) +
                              " % kept their level in these " + std::to_string(noise.frames) +
                              " frames: what they make of other stacks is most of the errors of these; take a longer "
                              "dark stack");
  ExponentialTail tail{.n = n, .limit = noise.least, .scatter = noise.scatter};
  double high = 0.0, highs = 0.0, changes = 0.0, spread = 0.0;
  for (const BlinkingPixel& pixel : noise.pixels) {
    tail.sum += pixel.excess - noise.least;
    high += pixel.high / n;
    changes += pixel.changes / n;
  }
  for (const BlinkingPixel& pixel : noise.pixels) {
    tail.squares += squared(pixel.excess - noise.least - tail.mean());
    highs += squared(pixel.high - high) / (n - 1.0);
    spread += squared(pixel.changes - changes) / (n - 1.0);
  }
  const double p = noise.change.value, steps = static_cast<double>(noise.frames) - 1.0;
  const auto [low, most] = noise.change95;
  const SeenPart seen{noise.seen, steps * (1.0 - noise.seen) / (1.0 - p) * noise.change.sd, seen_part(low, steps),
                      seen_part(most, steps)};
  add_exponential("blinking", tail, blinking.looked_at, seen, gain, unit, how, camera);
  const auto dwell = [](double chance) { return -2.0 / std::log1p(-2.0 * chance); };
  if (!(dwell(std::min(p, 0.499)) > 1.0) || !(most < 0.5))
    return undetermined("blinking_dwell", "frames", "the levels change from frame to frame; take frames faster");
  camera.findings.push_back({.name = "blinking_dwell",
                             .unit = "frames",
                             .value = dwell(p),
                             .sd = squared(dwell(p)) * noise.change.sd / (1.0 - 2.0 * p),
                             .low95 = dwell(most),
                             .high95 = dwell(low),
                             .from = how});
  // The variance of truncated binomial numbers is p (1 - p) times the square of p over its error, over n.
  const double binomial = squared(p * (1.0 - p) / noise.change.sd) / n;
  std::string other;
  if (std::abs(high - 0.5) > std::max(0.05, 4.5 * std::sqrt(highs / n)))
    other = "they are high for " + significant(100.0 * high, 2) + " % of the time, where the twin's are for half of it";
  else if (spread > binomial * (1.0 + 6.0 * std::sqrt((2.0 + 1.0 / (steps * p)) / n)))
    other = "some change more often than others, where the twin's have one dwell";
  else if (!tail.is_exponential())
    other = "their excesses are not exponentially distributed, as those of the twin are";
  if (!other.empty()) camera.warnings.push_back(from + ": blinking pixels: " + other);
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
