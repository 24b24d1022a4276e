// SPDX-License-Identifier: Apache-2.0

// What a stack says by itself, and whether stacks go together.

#include <algorithm>
#include <cmath>

#include "calib/characterize/characterize.h"
#include "calib/characterize/rounding.h"
#include "calib/edge/median.h"
#include "calib/fit/confidence/adequacy.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;
using radiometry::kT, radiometry::kV, radiometry::kH, radiometry::kTv, radiometry::kTh, radiometry::kVh,
    radiometry::kTvh;

constexpr double kShared_sd = 3.0;

double square(double x) { return x * x; }

/// Of the noise of a pixel in time, all of it, before rounding.
double unrounded_noise(const radiometry::MeanSquares& squares) {
  return unrounded_variance(squares.value[kTvh] + shared_variance(squares));
}

}  // namespace

StackSummary summary_of(const StackStatistics& stack) {
  StackSummary s{.frames = stack.frames(), .mean = stack.mean(), .squares = stack.mean_squares()};
  for (std::size_t k = 0; k < kLags.size(); ++k)
    if (stack.width() > std::abs(kLags[k].columns) && stack.height() > kLags[k].rows)
      s.covariance[k] = stack.covariance(kLags[k]);
  s.variances = stack.pixel_variances();
  s.rows_apart = stack.rows_apart();
  leave_out(s, {}, 1.0);
  s.share_low = stack.share_low();
  s.share_high = stack.share_high();
  s.at_low = stack.stuck(false);
  s.at_high = stack.stuck(true);
  s.von_neumann = stack.von_neumann();
  s.drift = stack.drift();
  s.step = stack.step();
  s.noise = stack.noise_scales();
  const double T = s.squares.frames, kept = static_cast<double>(s.variances.size());
  if (s.frames > 2 && s.squares.value[kTvh] > 0.0)
    s.frame_correlation = {stack.frame_correlation(),
                           std::sqrt((T - 2.0) * variance_of_products(s, kept, kept / s.squares.columns)) / (T - 1.0)};
  s.frame_means = stack.frame_means();
  s.pattern = mtf::Image(stack.width(), stack.height());
  for (std::int64_t i = 0; i < s.pattern.size(); ++i)
    s.pattern.data()[i] = static_cast<float>(stack.pixel_mean(i) - s.mean);
  return s;
}

double typical_variance(const StackSummary& s) {
  std::vector<double> variances(s.variances.begin(), s.variances.end());
  return median(variances) / chi_square_median(s.squares.frames - 1.0);
}

std::vector<std::int64_t> noisy_places(const StackSummary& s,
                                       const std::function<double(std::int64_t place)>& expected) {
  const double dof = s.squares.frames - 1.0;
  const auto columns = static_cast<std::int64_t>(s.squares.columns);
  const auto place_of = [&](std::int64_t i) { return i / columns * s.rows_apart * columns + i % columns; };
  std::vector<double> ratios(s.variances.begin(), s.variances.end());
  for (std::int64_t i = 0; expected && i < std::ssize(ratios); ++i)
    ratios[static_cast<std::size_t>(i)] /= expected(place_of(i));
  std::vector<double> any_order = ratios;
  const double most = median(any_order) / chi_square_median(dof) *
                      f_quantile(1.0 - kNoisy_p, dof, dof * static_cast<double>(ratios.size()));
  std::vector<std::int64_t> places;
  for (std::int64_t i = 0; i < std::ssize(ratios); ++i)
    if (ratios[static_cast<std::size_t>(i)] > most) places.push_back(place_of(i));
  return places;
}

PixelSeries empty_series(const StackSummary& s) {
  PixelSeries series{.places = noisy_places(s)};
  series.places.resize(std::min(series.places.size(), static_cast<std::size_t>(kMostSeriesValues / s.frames)));
  return series;
}

void leave_out(StackSummary& s, const std::set<std::int64_t>& places, double slowness) {
  const auto columns = static_cast<std::int64_t>(s.squares.columns);
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (std::int64_t i = 0; i < std::ssize(s.variances); ++i) {
    if (places.contains(i / columns * s.rows_apart * columns + i % columns)) continue;
    const auto one = static_cast<double>(s.variances[static_cast<std::size_t>(i)]);
    n += 1.0;
    sum += one;
    squares += one * one;
  }
  s.apart = {};
  if (n < static_cast<double>(s.variances.size())) {
    s.apart.value = s.squares.value[kTvh] - sum / n;
    for (const radiometry::CubePart part : {kT, kTv, kTh}) {
      const VarianceComponent shared = variance_component(s.squares, part);
      const double sd = slowness * shared.sd_of_zero;
      if (std::abs(shared.variance) > kShared_sd * sd) s.apart.value += shared.variance;
      s.apart.sd = std::hypot(s.apart.sd, sd);
    }
  }
  s.variance_sd = std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1.0) / (s.squares.rows * s.squares.columns));
}

std::map<int, std::int64_t> pixels_by_variance(const StackSummary& s) {
  std::map<int, std::int64_t> number;
  const double mean = pixel_variance(s.squares), bin = variance_bin(s);
  for (const float v : s.variances)
    if (v > 0.0F) ++number[static_cast<int>(std::lround(std::log(static_cast<double>(v) / mean) / bin))];
  return number;
}

double variance_of_products(const StackSummary& s, double pixels, double rows) {
  // Rows, columns and frames that share noise are fewer than pixels, and their sums scatter by the share's square.
  const double v = s.squares.value[kTvh];
  double all = v, squares = square(v) / pixels;
  for (const auto& [part, number] : {std::pair{kTv, rows}, std::pair{kTh, s.squares.columns}, std::pair{kT, 1.0}}) {
    const double shared = std::max(0.0, s.squares.variance(part));
    all += shared;
    squares += square(shared) / number + 2.0 * shared * v / pixels;
  }
  // Pixels that are noisier than others weigh more: the mean square of the variances, of which chi-square adds a part.
  const double of_pixels = (s.squares.rows * s.squares.columns * square(s.variance_sd) + square(all)) /
                           (1.0 + 2.0 / (s.squares.frames - 1.0));
  squares += std::max(0.0, of_pixels - square(all)) / pixels;
  return squares / square(all);
}

double shared_variance(const radiometry::MeanSquares& squares) {
  double sum = 0.0;
  for (const radiometry::CubePart part : {kTv, kTh, kT}) sum += std::max(0.0, squares.variance(part));
  return sum;
}

double pixel_variance(const radiometry::MeanSquares& squares) {
  return squares.value[kTvh] + squares.variance(kTv) + squares.variance(kTh) + squares.variance(kT);
}

double number_of_values(const Stack& stack) {
  return stack.sums.squares.frames * stack.sums.squares.rows * stack.sums.squares.columns;
}

std::string clipped_words(const Stack& stack) {
  if (stack.saturates)
    return "the pixels are full at " + significant(stack.sums.mean, 5) +
           " counts, below the end of the scale: mean and noise no longer rise with the light";
  const bool high = stack.is_clipped_high();
  return significant(100.0 * (high ? stack.sums.share_high : stack.sums.share_low), 3) +
         " % of the values are at the " + (high ? "upper" : "lower") + " end of the scale";
}

std::string left_out_words(const Stack& stack) {
  return stack.name + ": " + clipped_words(stack) + "; left out of the fit";
}

std::string other_exposure_words(const std::string& name, double time_s, const std::set<double>& dark_s) {
  constexpr double kSame = 0.01;
  if (dark_s.size() != 1 || std::abs(time_s - *dark_s.begin()) <= kSame * std::max(time_s, *dark_s.begin())) return "";
  return name + ": exposed for " + mtf::significant(1e3 * time_s, 4) + " ms, every dark stack for " +
         mtf::significant(1e3 * *dark_s.begin(), 4) +
         " ms: the dark signal of the difference would count as light; give dark stacks of the same exposure, or of "
         "two exposures, from which the dark current follows";
}

void require_dark_exposures(const std::vector<Stack>& stacks) {
  std::set<double> dark_s;
  for (const Stack& stack : stacks)
    if (stack.is_usable() && !(stack.light > 0.0)) dark_s.insert(stack.time_s);
  for (const Stack& stack : stacks) {
    const std::string words =
        stack.is_usable() && stack.light > 0.0 ? other_exposure_words(stack.name, stack.time_s, dark_s) : "";
    if (!words.empty()) throw mtf::UsageError(words);
  }
}

bool is_hidden_by_rounding(const Stack& stack) {
  const radiometry::MeanSquares& squares = stack.sums.squares;
  const double spread2 = squares.variance(kVh) + squares.variance(kV) + squares.variance(kH);
  return unrounded_noise(squares) < square(kHidden_counts) && spread2 < square(0.5);
}

double rounding_of(const Stack& stack) { return rounding_pattern(unrounded_noise(stack.sums.squares)); }

mtf::Image pattern_difference(const Stack& stack, const Stack& other) {
  mtf::Image d = stack.sums.pattern.clone();
  for (std::int64_t i = 0; i < d.size(); ++i) d.data()[i] -= other.sums.pattern.data()[i];
  return d;
}

void mark_stuck(std::vector<Stack>& stacks) {
  for (const auto& [places, share] :
       {std::pair{&StackSummary::at_low, &Stack::stuck_low}, {&StackSummary::at_high, &Stack::stuck_high}}) {
    std::vector<std::int64_t> all = stacks.empty() ? std::vector<std::int64_t>() : stacks.front().sums.*places;
    for (const Stack& stack : stacks)
      std::erase_if(all, [&, at = places](std::int64_t i) { return !std::ranges::binary_search(stack.sums.*at, i); });
    for (Stack& stack : stacks)
      stack.*share = static_cast<double>(all.size()) / (stack.sums.squares.rows * stack.sums.squares.columns);
  }
}

void mark_saturated(const std::vector<Stack*>& stacks) {
  const auto noise = [](const Stack& stack) { return stack.sums.squares.value[kTvh]; };
  for (Stack* const stack : stacks) stack->saturates = false;
  /// Of the stacks that are not full and have less light than one: the brightest, and the largest noise.
  struct Below {
    const Stack* last = nullptr;
    double peak = 0.0;
  };
  std::vector<Below> below(stacks.size());
  Below less, met;  // of less light than the stack at hand, and of all before it
  const Stack* dark = nullptr;
  std::size_t first = stacks.size();
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    Stack& stack = *stacks[i];
    if (!stack.is_usable()) continue;
    if (dark == nullptr) dark = &stack;
    if (met.last != nullptr && met.last->light < stack.light) less = met;
    below[i] = less;
    if (first == stacks.size() && less.last != nullptr && less.last->light > dark->light) {
      const double expected = (less.last->sums.mean - dark->sums.mean) / (less.last->light - dark->light);
      const double rise = stack.sums.mean - less.last->sums.mean, due = expected * (stack.light - less.last->light);
      if (rise > -1e-3 * due && noise(stack) < 0.67 * less.peak && less.peak > 1.5 * noise(*dark)) first = i;
    }
    stack.saturates = first != stacks.size();
    if (!stack.saturates) met = {&stack, std::max(met.peak, noise(stack))};
  }
  if (first == stacks.size()) return;
  while (first-- > 0) {
    Stack& stack = *stacks[first];
    const Stack* const last = below[first].last;
    if (!stack.is_usable() || last == nullptr || !(last->light > dark->light) || !(noise(stack) < noise(*last))) return;
    stack.saturates = true;
  }
}

std::array<Estimate, kLags.size()> pixel_covariance(const StackSummary& stack) {
  const radiometry::MeanSquares& squares = stack.squares;
  const double v = squares.value[kTvh], times = squares.frames - 1.0, V = squares.rows, H = squares.columns;
  const double t = squares.variance(kT), tv = std::max(0.0, squares.variance(kTv)),
               th = std::max(0.0, squares.variance(kTh));
  std::array<Estimate, kLags.size()> result{};
  for (std::size_t k = 0; k < kLags.size(); ++k) {
    const bool one_row = kLags[k].rows == 0, one_column = kLags[k].columns == 0;
    const double shared = t + (one_row ? squares.variance(kTv) : 0.0) + (one_column ? squares.variance(kTh) : 0.0);
    // n pixels of a line that correlate at this lag raise the line's component by 2 (n - lag) / (n (n - 1)) of it.
    const double n = one_row ? H : V, lag = kLags[k].rows + std::abs(kLags[k].columns);
    const double kept = one_row || one_column ? 1.0 - 2.0 * (n - lag) / (n * (n - 1.0)) : 1.0;
    if (!(kept > 0.0) || stack.covariance[k].pairs == 0.0) continue;
    // Noise of two rows that differ has products too, few of them: one a pair of rows.
    const double rows = one_row ? 0.0 : tv, columns = one_column ? 0.0 : th;
    // At the ends of its line a pixel has one neighbour, which leaves a part of what the line shares.
    const double edge =
        2.0 * lag * ((one_row ? tv / H : 0.0) + (one_column ? th / V : 0.0) + std::abs(t) * (1.0 / H + 1.0 / V));
    const double variance =
        v * (v + 2.0 * (rows + columns) + edge) / stack.covariance[k].pairs + square(rows) / V + square(columns) / H;
    result[k] = {(stack.covariance[k].value - shared) / kept, std::sqrt(variance / times) / kept};
  }
  return result;
}

void require_sound(const std::vector<Stack>& stacks, double light_repeatability) {
  if (stacks.empty()) throw mtf::UsageError("no stacks; give flat frames at several exposures");
  const radiometry::MeanSquares& first = stacks.front().sums.squares;
  double ratio = 0.0, spread = 0.0;
  int counted = 0;
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    const Stack& stack = stacks[i];
    const radiometry::MeanSquares& one = stack.sums.squares;
    if (one.rows != first.rows || one.columns != first.columns)
      throw mtf::UsageError(stack.name + ": frames of " + significant(one.columns, 9) + " x " +
                            significant(one.rows, 9) + ", those of " + stacks.front().name + " are " +
                            significant(first.columns, 9) + " x " + significant(first.rows, 9) + "; give all one size");
    if (!(one.value[kTvh] > 0.0) && one.variance(kVh) > 0.0)
      throw mtf::UsageError(stack.name + ": its frames are alike, pixel by pixel; give frames as they come, no copies");
    if (stack.light > 0.0 && stack.is_usable() && stack.sums.frames >= 4) {
      const auto T = static_cast<double>(stack.sums.frames);
      ratio += stack.sums.von_neumann;
      spread += 4.0 * (T - 2.0) / (T * T - 1.0);
      ++counted;
    }
    if (i == 0 || !stack.is_usable() || !stacks[i - 1].is_usable() || stack.time_s < stacks[i - 1].time_s) continue;
    const double sd = std::sqrt(one.value[kTvh] / number_of_values(stack)) + 1e-3 * std::abs(stack.sums.mean);
    if (stack.light > stacks[i - 1].light && stack.sums.mean < stacks[i - 1].sums.mean - 5.0 * sd)
      throw mtf::UsageError(stack.name + " has more light than " + stacks[i - 1].name + ", but a lower mean (" +
                            significant(stack.sums.mean, 6) + " after " + significant(stacks[i - 1].sums.mean, 6) +
                            " counts); stacks and their light are paired wrongly");
  }
  if (counted == 0) return;
  const double least = std::min(1.2, 2.0 - 4.5 * std::sqrt(spread) / counted);
  if (ratio / counted < least)
    throw mtf::UsageError(
        "the light drifts within the stacks: von Neumann's ratio of the frames' means is " +
        significant(ratio / counted, 3) +
        ", 2 for a steady one; let lamp or blackbody, and camera, warm up, or take the exposures in turn");
  // The signal is that above a dark, or the span of the blackbodies; without a dark it is not known.
  const bool thermal = stacks.back().light_per_k > 0.0;
  if (!thermal && stacks.front().light > 0.0) return;
  for (const Stack& stack : stacks) {
    const double signal = (thermal ? stacks.back() : stack).sums.mean - stacks.front().sums.mean,
                 T = static_cast<double>(stack.sums.frames);
    const FrameDrift& drift = stack.sums.drift;
    const double share = drift.value / signal, most = std::max(1e-3, 3.0 * light_repeatability);
    if (!(stack.light > 0.0 && stack.is_usable() && signal > 0.0 && std::abs(share) * (T - 1.0) > most)) continue;
    const double p = drift.sd > 0.0 ? f_tail(square(drift.value / drift.sd), 1.0, T - 2.0) : 0.0;
    if (p * counted < 1e-4)
      throw mtf::UsageError(stack.name + ": the light drifts, by " + significant(100.0 * share, 2) +
                            " % of the signal from frame to frame (p = " + significant(p, 2) +
                            "), so that its exposure is not the one that is stated; let lamp or blackbody, and camera, "
                            "warm up, and take this stack again or leave it out");
  }
}

}  // namespace calib
