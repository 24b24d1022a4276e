// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/characterize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "calib/characterize/defect_pixels.h"
#include "calib/characterize/rounding.h"
#include "calib/fit/fit_report.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;
using radiometry::kT, radiometry::kTh, radiometry::kTv, radiometry::kTvh;

constexpr double kSure_sd = 3.0;

double square(double x) { return x * x; }

std::string hidden_why() { return "rounding hides " + hidden_words(); }

/// Sum of the variances of a part over the stacks by their weights, in its standard deviations.
double significance(const std::vector<Stack>& stacks, radiometry::CubePart part) {
  double sum = 0.0, weights = 0.0;
  for (const Stack& stack : stacks) {
    const VarianceComponent one = variance_component(stack.sums.squares, part);
    if (!stack.is_usable() || !(one.sd_of_zero > 0.0)) continue;
    sum += one.variance / square(one.sd_of_zero);
    weights += 1.0 / square(one.sd_of_zero);
  }
  return weights > 0.0 ? sum / std::sqrt(weights) : 0.0;
}

std::vector<Stack*> by_light(std::vector<Stack>& stacks) {
  std::vector<Stack*> sorted;
  for (Stack& stack : stacks) sorted.push_back(&stack);
  std::stable_sort(sorted.begin(), sorted.end(), [](const Stack* a, const Stack* b) {
    return a->light != b->light ? a->light < b->light : a->time_s < b->time_s;
  });
  return sorted;
}

/// Relative variance of the light from frame to frame, less that of the dark; 0 where it is not above 3 sd.
double flicker_of(const std::vector<Stack>& stacks, double dark_mean) {
  double sum = 0.0, weights = 0.0;
  for (const Stack& stack : stacks) {
    const double signal = stack.sums.mean - dark_mean;
    if (!stack.is_usable() || !(stack.light > 0.0) || !(signal > 0.0)) continue;
    const VarianceComponent t = variance_component(stack.sums.squares, kT);
    const double weight = square(square(signal)) / square(t.sd_of_zero);
    sum += weight * t.variance / square(signal);
    weights += weight;
  }
  return weights > 0.0 && sum > kSure_sd * std::sqrt(weights) ? sum / weights : 0.0;
}

/// The stacks whose mean frames tell the patterns; null where there is none with a plane.
struct Choice {
  const Stack* dark = nullptr;     ///< in the dark: with the most frames, of those the shortest
  const Stack* longest = nullptr;  ///< in the dark
  const Stack* bright = nullptr;   ///< with the most light in all its frames, which the noise of a pattern falls with
};
/// `below`: of the light of the bright one.
Choice choice_of(const std::vector<Stack>& stacks, double below = std::numeric_limits<double>::infinity()) {
  Choice choice;
  for (const Stack& s : stacks) {
    if (!s.is_usable() || s.sums.pattern.size() == 0) continue;
    const auto frames = static_cast<double>(s.sums.frames);
    if (s.light > 0.0) {
      if (!(s.light < below)) continue;
      const Stack*& best = choice.bright;
      if (best == nullptr || s.light * frames > best->light * static_cast<double>(best->sums.frames)) best = &s;
      continue;
    }
    const Stack*& best = choice.dark;
    if (best == nullptr || s.sums.frames > best->sums.frames ||
        (s.sums.frames == best->sums.frames && s.time_s < best->time_s))
      best = &s;
    if (choice.longest == nullptr || s.time_s >= choice.longest->time_s) choice.longest = &s;
  }
  return choice;
}

class Analysis {
 public:
  Analysis(std::vector<Stack> stacks, const CharacterizeOptions& options) : options_(options) {
    for (Stack* const stack : by_light(stacks)) result_.stacks.push_back(std::move(*stack));
    mark_stuck(result_.stacks);
    mark_saturated(by_light(result_.stacks));
    require_sound(result_.stacks, options_.light_repeatability);
    if (options_.counts_time) require_dark_exposures(result_.stacks);
    find_planes();
    make_levels();
    fit();
    add_transfer();
    add_lines();
    add_patterns();
    add_slow_noise(slow_, result_.dark, gain_, result_);
    add_noise_in_time(result_.stacks, result_.findings, result_.warnings, slow_.found || blinking_.found(),
                      blinking_.explained());
    add_unknowable();
  }

  Characterization take() { return std::move(result_); }

 private:
  void find_planes();
  void make_levels();
  void fit();
  void correct_for_crosstalk();
  void add_transfer();
  void add_lines();
  void add_patterns();
  void add_unknowable();

  void add(Finding finding) { result_.findings.push_back(std::move(finding)); }
  void not_determined(const std::string& name, const std::string& unit, const std::string& why) {
    add({.name = name, .unit = unit, .verdict = Verdict::not_determined, .why = why});
  }
  void add_value(const std::string& name, const std::string& unit, const Estimate& e, const std::string& from) {
    add(finding_of(name, unit, e, from));
  }
  /// The root of a variance in counts^2, over `divisor`: a value where the variance is clearly above 0, else a limit.
  void add_rms(const std::string& name, const std::string& unit, const VarianceComponent& c, const Estimate& divisor,
               const std::string& from, std::optional<double> variance_sd_array = std::nullopt) {
    const auto root = [&](double v) { return std::sqrt(std::max(0.0, v)) / divisor.value; };
    Finding f{.name = name, .unit = unit, .from = from};
    f.value = root(c.variance);
    f.low95 = root(c.low95);
    f.high95 = root(c.most());
    f.verdict = c.low95 > 0.0 ? Verdict::determined : Verdict::upper_limit;
    if (f.value > 0.0) {
      // The divisor's error is independent of the variance's.
      const double by_divisor = f.value * divisor.sd / divisor.value;
      const auto sd = [&](double of_variance) {
        return std::hypot(of_variance / (2.0 * f.value * square(divisor.value)), by_divisor);
      };
      f.sd = sd(c.sd);
      if (variance_sd_array) f.sd_array = sd(*variance_sd_array);
      if (f.low95 > 0.0) f.low95 = std::max(0.0, f.value - std::hypot(f.value - f.low95, k95_sd * by_divisor));
      f.high95 = f.value + std::hypot(f.high95 - f.value, k95_sd * by_divisor);
    }
    if (c.sd_of_zero > 0.0 && c.variance < -4.0 * c.sd_of_zero)
      result_.warnings.push_back(name + ": the variance is negative by " + significant(-c.variance / c.sd_of_zero, 2) +
                                 " standard deviations, as independent pixels do not give it");
    add(std::move(f));
  }
  const Stack* darkest() const { return dark_stack(result_.stacks); }

  CharacterizeOptions options_;
  Characterization result_;
  bool read_hidden_ = false;      ///< by rounding
  PlaneSquares dark_, response_;  ///< of the dark stack's pattern, and of that of the light
  Trend trend_;                   ///< that was taken from the latter
  DefectSums defects_;
  BlinkingPixels blinking_;
  bool hot_changes_ = false;
  SlowNoise slow_;
  double working_ = 1.0;     ///< share of the pixels that are not dead
  double own_charge_ = 1.0;  ///< share of its charge that crosstalk leaves a pixel
  double taken_ = 0.0;       ///< mean of the defects that the levels are without, counts
  Estimate gain_;            ///< counts per electron, corrected
};

void Analysis::find_planes() {
  const auto [dark, longest, bright] = choice_of(result_.stacks);
  if (dark == nullptr) return;
  const CrosstalkEstimate& c = result_.crosstalk;
  const double side = c.found ? c.side.value : 0.0, corner = c.corner_found ? c.corner.value : 0.0;
  std::set<std::int64_t> without;
  const auto squares_of = [&](const mtf::Image& given, int trend) {
    PlaneSquares squares = plane_squares(given.view(), trend, without);
    if (!c.found || squares.defects.empty()) return squares;
    mtf::Image plane = given.clone();
    take_back_leaks(plane, squares.defects, side, corner);
    return plane_squares(plane.view(), trend, without);
  };
  result_.dark = static_cast<int>(dark - result_.stacks.data());
  dark_ = squares_of(dark->sums.pattern, 0);
  mtf::Image lit;
  if (bright != nullptr) {
    result_.bright = static_cast<int>(bright - result_.stacks.data());
    lit = pattern_difference(*bright, *dark);
    trend_ = remove_trend(lit.view(), options_.trend);
    result_.trend = trend_.degree;
    response_ = squares_of(lit, trend_.degree);
  }
  if (is_hidden_by_rounding(*dark)) return;
  if (!c.found) slow_ = slow_noise_of(*dark);
  const double signal = bright != nullptr ? bright->sums.mean - dark->sums.mean : 0.0;
  const bool tells = bright != nullptr && signal > 0.0 && !(rounding_of(*dark) > 1e-4);
  const double more = tells ? bright->sums.squares.value[kTvh] - dark->sums.squares.value[kTvh] : 0.0;
  const double shot = more > 0.0 ? more / signal : 0.0;
  blinking_ = tells ? blinking_pixels(dark->sums, dark_, shot, side) : BlinkingPixels();
  if (blinking_.found()) {  // their mean frames are other ones in each stack
    without = blinking_.restless;
    for (const std::int64_t place : noisy_for_light(*bright, *dark, *bright, dark_, shot)) without.insert(place);
    dark_ = squares_of(dark->sums.pattern, 0);
    response_ = squares_of(lit, trend_.degree);
  }
  defects_ = defect_sums(dark_, bright != nullptr ? &response_ : nullptr, signal, without);
  own_charge_ = 1.0 - 4.0 * (side + corner);
  defects_.mean /= own_charge_;
  // What hot pixels add grows with the exposure, or does not: of several exposures it is left where it is.
  hot_changes_ = options_.counts_time && exposures_differ(result_.stacks);
  if (hot_changes_) defects_.mean = 0.0, defects_.with_noise.clear();
  const auto columns = static_cast<std::int64_t>(dark_.columns);
  for (const std::int64_t place : without)  // and what crosstalk gives their neighbours
    for (const std::int64_t away : {std::int64_t{0}, -columns, std::int64_t{-1}, std::int64_t{1}, columns})
      if (away == 0 || side > 0.0) defects_.with_noise.insert(place + away);
  for (Stack& stack : result_.stacks) {
    stack.sums.lasting = slow_.of_mean(stack.sums.squares.frames);
    std::set<std::int64_t> places = defects_.with_noise;
    if (blinking_.found())  // and those that changed in this stack alone
      for (const std::int64_t place : noisy_for_light(stack, *dark, *bright, dark_, shot)) places.insert(place);
    leave_out(stack.sums, places, blinking_.slowness());
  }
  working_ = 1.0 - static_cast<double>(defects_.dead) / (dark_.rows * dark_.columns);
}

void Analysis::make_levels() {
  taken_ = defects_.mean;
  std::vector<Stack>& stacks = result_.stacks;
  const bool lines = significance(stacks, kTv) > kSure_sd || significance(stacks, kTh) > kSure_sd;
  const double dark_mean = stacks.front().sums.mean;
  const Stack* dark = darkest();
  const VarianceComponent dark_frames = dark ? variance_component(dark->sums.squares, kT) : VarianceComponent();
  const bool frames = dark && dark_frames.variance > kSure_sd * dark_frames.sd_of_zero;
  const double flicker = frames ? 0.0 : flicker_of(stacks, dark_mean);
  result_.level_of.assign(stacks.size(), -1);
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    const Stack& stack = stacks[i];
    const StackSummary& s = stack.sums;
    if (!stack.is_usable()) {
      result_.warnings.push_back(left_out_words(stack));
      continue;
    }
    const double v = s.squares.value[kTvh], n = number_of_values(stack), T = s.squares.frames;
    const double pattern = rounding_of(stack);
    TransferLevel level{.light = stack.light, .time_s = stack.time_s, .mean = s.mean - taken_};
    level.mean_variance = (lines ? std::max(v, s.squares.value[kTv] + s.squares.value[kTh] - v) : v) / n +
                          (pattern + s.lasting) * T / n + (frames ? dark_frames.variance / T : 0.0);
    level.mean_variance += blinking_.mean_variance(T, s.squares.rows * s.squares.columns);
    level.variance = v - s.apart.value - slow_.within(T);
    level.shared = shared_variance(s.squares);
    level.dof = s.squares.dof(kTvh) * slow_.freedom(v, T) * square(level.variance / (level.variance + slow_.within(T)));
    const double unseen = static_cast<int>(i) == result_.dark ? 0.0 : blinking_.unseen_variance(T);
    if (s.apart.value != 0.0 || unseen > 0.0) {
      const double known = 2.0 * static_cast<double>(s.rows_apart) / level.dof + square(s.apart.sd / level.variance);
      blinking_.unseen_count = blinking_.unseen_count || unseen > level.variance * std::sqrt(known);
      level.dof = 2.0 / (known + square(unseen / level.variance));
    }
    // Rounded noise of a pixel is not normal; what it shares scatters with it.
    if (v < 1.5) level.variance_sd = s.variance_sd * v / (v + level.shared);
    level.light_sd = std::sqrt(square(options_.light_repeatability) + flicker / T);
    if (is_hidden_by_rounding(stack)) {
      level.variance_counts = false;
      level.mean_variance += 1.0 / 12.0;
      read_hidden_ = read_hidden_ || stack.light == 0.0;
      result_.warnings.push_back(stack.name + ": " + hidden_words() +
                                 ": what rounding makes of it depends on the offset; its variance is left out");
    }
    result_.level_of[i] = static_cast<int>(result_.levels.size());
    result_.levels.push_back(level);
  }
  if (result_.levels.empty())
    throw mtf::UsageError("every stack has values at an end of the scale; expose between the ends, and check bits");
  if (flicker > 0.0)
    add_value("light_flicker", "", {std::sqrt(flicker), 0.0}, "from frame to frame; part of the errors of the means");
}

void Analysis::fit() {
  std::set<double> dark_times;
  for (const TransferLevel& level : result_.levels)
    if (level.light == 0.0) dark_times.insert(level.time_s);
  TransferOptions how{.nonlinearity = options_.nonlinearity,
                      .full_well_e = options_.full_well_e,
                      .dark_current = options_.counts_time && dark_times.size() > 1};
  if (how.nonlinearity > 0 && !(how.full_well_e > 0.0)) {
    // Any scale serves: that of the converter's range, by a gain of the levels with little signal.
    const TransferLevel &low = result_.levels.front(), &high = result_.levels.back();
    const TransferLevel& middle = result_.levels[result_.levels.size() / 2];
    const double gain = (middle.variance - low.variance) / (middle.mean - low.mean);
    const double most = options_.most_counts > 0.0 ? options_.most_counts : high.mean;
    if (gain > 0.0) how.full_well_e = std::max(high.mean, most) / gain;
    if (!(how.full_well_e > 0.0)) how.full_well_e = 1.0;  // the fit itself refuses such levels
    how.full_well_e = std::stod(significant(how.full_well_e, 2));
  }
  result_.full_well_e = how.full_well_e;
  result_.transfer = fit_photon_transfer(result_.levels, how);
  correct_for_crosstalk();
  if (result_.crosstalk.found) {
    const double V = result_.stacks.front().sums.squares.rows, H = result_.stacks.front().sums.squares.columns;
    const auto& r = result_.crosstalk.ratio;
    double squares = 1.0, sum = 1.0;
    for (const Estimate& ratio : r) {
      squares += 2.0 * square(ratio.value);
      sum += 2.0 * ratio.value;
    }
    // With correlated neighbours the mean square tvh is low, its scatter and that of the mean are larger.
    for (std::size_t i = 0; i < result_.levels.size(); ++i) {
      TransferLevel& level = result_.levels[i];
      const PhotonTransfer::Level& model = result_.transfer.levels[i];
      const double shot = square(result_.transfer.gain.value * model.slope) * model.electrons;
      level.variance += 2.0 * shot * (r[0].value / H + r[1].value / V);
      level.mean_variance *= 1.0 + (sum - 1.0) * shot / level.variance;
      level.dof /= squares;
    }
    result_.transfer = fit_photon_transfer(result_.levels, how);
    correct_for_crosstalk();
    find_planes();  // without what defects gave their neighbours
  }
  const PhotonTransfer& t = result_.transfer;
  const Estimate& q = result_.crosstalk.power;
  gain_.value = t.gain.value / q.value;
  gain_.sd = gain_.value * std::hypot(t.gain.sd / t.gain.value, q.sd / q.value);
  result_.misfit = !t.converged || t.p < options_.misfit_p;
  if (!result_.misfit) return;
  const auto size = [](const PhotonTransfer::Level& l) { return std::max(std::abs(l.mean_z), std::abs(l.variance_z)); };
  const auto worst = std::max_element(t.levels.begin(), t.levels.end(),
                                      [&](const auto& a, const auto& b) { return size(a) < size(b); });
  const auto stack = std::find(result_.level_of.begin(), result_.level_of.end(), worst - t.levels.begin());
  result_.misfit_reason =
      t.converged
          ? "chi-square " + significant(t.chi2, 4) + " with " + std::to_string(t.dof) +
                " degrees of freedom, p = " + significant(t.p, 2) + "; the level that disagrees most is " +
                result_.stacks[static_cast<std::size_t>(stack - result_.level_of.begin())].name + " (mean " +
                significant(worst->mean_z, 2) + ", variance " + significant(worst->variance_z, 2) +
                " standard deviations): more terms of nonlinearity, the repeatability of the light, or this level "
                "left out if its brightest pixels are full"
          : "the fit does not converge";
}

void Analysis::correct_for_crosstalk() {
  std::vector<CorrelatedLevel> levels;
  for (std::size_t i = 0; i < result_.stacks.size(); ++i) {
    if (result_.level_of[i] < 0 || is_hidden_by_rounding(result_.stacks[i])) continue;
    const StackSummary& s = result_.stacks[i].sums;
    const PhotonTransfer::Level& model = result_.transfer.levels[static_cast<std::size_t>(result_.level_of[i])];
    levels.push_back({.covariance = pixel_covariance(s),
                      .shot = square(result_.transfer.gain.value * model.slope) * model.electrons});
  }
  result_.crosstalk = estimate_crosstalk(levels);
}

void Analysis::add_transfer() {
  const PhotonTransfer& t = result_.transfer;
  const Estimate& q = result_.crosstalk.power;
  const double inverse = 1.0 / gain_.value;
  const std::string from = "fit of the means and variances of " + std::to_string(t.levels.size()) + " levels" +
                           (result_.crosstalk.found ? ", corrected for crosstalk" : "");
  // There are 1/q apparent electrons for one: rates fall by q, a rises, and the error of q adds.
  const auto scaled = [&](const Estimate& e, double power) {
    const double factor = std::pow(q.value, power);
    return Estimate{e.value * factor, std::hypot(e.sd * factor, power * e.value * factor * q.sd / q.value)};
  };
  add_value("electrons_per_count", "e-", {inverse, inverse * gain_.sd / gain_.value}, from);
  const CrosstalkEstimate& c = result_.crosstalk;  // which gave the neighbours of defects a part
  const double leaks_sd = 4.0 * defects_.mean / own_charge_ * std::hypot(c.side.sd, c.corner.sd);
  const double offset_sd = std::hypot(t.offset.sd, leaks_sd, blinking_.unseen_mean());
  add_value("offset", "counts", {t.offset.value + taken_ - defects_.mean, offset_sd}, from);
  Estimate read2 = scaled(t.read2, 2.0);  // without the 1/f noise
  read2.sd = std::hypot(read2.sd, slow_.within_sd(static_cast<double>(slow_.frames)) / square(gain_.value));
  const VarianceComponent read{.variance = read2.value,
                               .sd = read2.sd,
                               .low95 = read2.value - k95_sd * read2.sd,
                               .high95 = read2.value + k95_sd * read2.sd,
                               .sd_of_zero = read2.sd};
  add_rms("read_noise", "e-", read, {1.0, 0.0}, from);
  if (read_hidden_) {
    Finding& finding = result_.findings.back();
    finding.verdict = Verdict::upper_limit;
    finding.why = hidden_why();
  }
  // The mean over all pixels is that of the working ones times their share.
  const auto of_working = [&](Estimate e, int power) {
    const double factor = std::pow(working_, power);
    return Estimate{e.value * factor, e.sd * factor};
  };
  add_value("rate", "e- per unit of light", of_working(scaled(t.rate, 1.0), -1), from);
  for (std::size_t k = 0; k < t.a.size(); ++k) {
    const int power = static_cast<int>(k) + 1;
    add_value(t.names[4 + k], "", of_working(scaled(t.a[k], -power), power), from);
  }
  if (t.dark) {
    add_value("dark_current", "e-/s", of_working(scaled(*t.dark, 1.0), -1), from);
    Finding& finding = result_.findings.back();
    if (finding.low95 <= 0.0) finding.verdict = Verdict::upper_limit;
    if (finding.high95 < 0.0) result_.warnings.push_back("the dark signal falls with the exposure time");
  } else {
    not_determined(
        "dark_current", "e-/s",
        "it takes dark stacks of two exposure times; until then its noise is in read_noise, its mean in offset");
  }
  const std::string by = "covariances of neighbours over the levels";
  if (!(c.side.sd > 0.0)) {
    not_determined("crosstalk_side", "", "no level has light, or the frames are too few or too small to tell");
  } else {
    add_value("crosstalk_side", "", c.side, by);
    if (!c.found) {
      Finding& side = result_.findings.back();
      side.verdict = Verdict::upper_limit;
      side.high95 = std::max(0.0, side.high95);
      if (side.value < -5.0 * side.sd)
        result_.warnings.push_back(
            "crosstalk_side is negative (" + significant(side.value, 2) + " +- " + significant(side.sd, 2) +
            "): the noise of neighbours runs against each other, as a sharpening filter makes it; "
            "gain and noise are wrong behind it; give raw frames");
    }
    if (c.corner_found) add_value("crosstalk_corner", "", c.corner, by);
  }
  if (const Stack* dark = darkest()) warn_of_neighbours(*dark, result_.warnings);
}

void Analysis::add_lines() {
  // Row and column noise is pooled by weights; neighbours that share shot noise feign it, so then from the dark alone.
  std::vector<const Stack*> pooled;
  for (const Stack& stack : result_.stacks)
    if (stack.is_usable() && !is_hidden_by_rounding(stack) && !(result_.crosstalk.found && stack.light > 0.0))
      pooled.push_back(&stack);
  const auto pool = [&](radiometry::CubePart part) {
    std::vector<MeanSquareTerm> terms;
    double weights = 0.0;
    for (const Stack* stack : pooled) weights += 1.0 / square(variance_component(stack->sums.squares, part).sd_of_zero);
    for (const Stack* stack : pooled) {
      const double weight = 1.0 / square(variance_component(stack->sums.squares, part).sd_of_zero) / weights;
      for (const MeanSquareTerm& term : terms_of(stack->sums.squares, part, weight)) terms.push_back(term);
    }
    return variance_component(terms);
  };
  const std::string why = "with crosstalk it takes a dark stack that is not clipped";
  for (const auto& [name, part] : {std::pair{"row_noise", kTv}, std::pair{"column_noise", kTh}}) {
    if (pooled.empty())
      not_determined(name, "e-", darkest() == nullptr ? why : hidden_why());
    else
      add_rms(name, "e-", pool(part), gain_, result_.crosstalk.found ? "the dark stacks" : "all stacks, pooled");
  }
  if (const Stack* dark = darkest(); dark != nullptr && is_hidden_by_rounding(*dark))
    not_determined("frame_noise", "e-", hidden_why());
  else if (dark != nullptr)
    add_rms("frame_noise", "e-", variance_component(dark->sums.squares, kT), gain_, dark->name);
}

void Analysis::add_patterns() {
  const auto [dark, longest, bright] = choice_of(result_.stacks);
  const PlaneSquares &plane = dark_, &squares = response_;
  const std::string no_dark = result_.stacks.front().light == 0.0
                                  ? "the dark stack is clipped at the lower end; raise the offset"
                                  : "no dark stack; give one with light = false";
  const bool hidden = dark != nullptr && is_hidden_by_rounding(*dark);
  if (dark == nullptr || hidden)
    for (const auto& [name, unit] : {std::pair{"dsnu", "e-"}, std::pair{"fixed_row", "e-"},
                                     std::pair{"fixed_column", "e-"}, std::pair{"hot_fraction", ""}})
      not_determined(name, unit, hidden ? hidden_why() : no_dark);
  if (dark == nullptr || bright == nullptr)
    for (const char* const name : {"prnu", "prnu_row", "prnu_column", "dead_fraction"})
      not_determined(name, "", dark == nullptr ? no_dark : "no level has light");
  if (dark == nullptr) return;
  // The planes are without defects, whose noise is in the mean squares.
  const auto averaged = [&](const Stack& stack) {
    const double T = stack.sums.squares.frames;
    return AveragedStack{stack.sums.squares, rounding_of(stack) + stack.sums.lasting - stack.sums.apart.value / T,
                         slow_.of_mean_sd(T)};
  };
  const AveragedStack dark_stack = averaged(*dark);
  const Pattern fixed = pattern_of(plane, {dark_stack});
  if (!hidden) {
    add_rms("dsnu", "e-", fixed.pixel, gain_, dark->name, fixed.pixel_sd_array);
    add_rms("fixed_row", "e-", fixed.row, gain_, dark->name, fixed.row_sd_array);
    add_rms("fixed_column", "e-", fixed.column, gain_, dark->name, fixed.column_sd_array);
    warn_of_shape("dsnu", plane, result_.warnings);
    result_.defects = plane.defects;
    const double own_relative = std::hypot(gain_.sd / gain_.value, 4.0 * result_.crosstalk.side.sd / own_charge_);
    const Estimate own_gain{gain_.value * own_charge_, gain_.value * own_charge_ * own_relative};
    if (hot_changes_)
      not_determined("hot_fraction", "", std::string(kHotChanges));
    else
      add_hot_pixels(defects_, dark_, own_gain, "e-", dark->name, result_);
    if (!(rounding_of(*dark) > 1e-4)) add_blinking_pixels(blinking_, own_gain, "e-", dark->name, result_);
    if (bright != nullptr) add_dead_pixels(defects_, dark_.rows * dark_.columns, dark->name, result_);
  } else if (bright != nullptr) {
    not_determined("dead_fraction", "", hidden_why());
  }

  if (bright != nullptr) {
    const int index = result_.level_of[static_cast<std::size_t>(result_.bright)];
    const PhotonTransfer::Level& level = result_.transfer.levels[static_cast<std::size_t>(index)];
    // K g' e of the apparent numbers is that of the true ones; crosstalk smooths the pattern of white pixels by its
    // power.
    const double signal = result_.transfer.gain.value * level.slope * level.electrons / working_;
    result_.bright_signal = signal;
    const Estimate &q = result_.crosstalk.power, lines{signal, 0.0},
                   pixels{signal * std::sqrt(q.value), signal * 0.5 * q.sd / std::sqrt(q.value)};
    const Trend& trend = trend_;
    Pattern response = pattern_of(squares, {averaged(*bright), dark_stack});
    const std::string from = bright->name + " less " + dark->name;
    // Crosstalk makes the responses of neighbours alike: the means of lines scatter by 2 r / n of the pixels' more.
    const auto lower = [&](VarianceComponent& line, std::size_t lag, double n) {
      const double raised = 2.0 * result_.crosstalk.ratio[lag].value * response.pixel.variance / n;
      for (double* const part : {&line.variance, &line.low95, &line.high95}) *part -= raised;
    };
    if (result_.crosstalk.found) {
      lower(response.row, 0, squares.columns);
      lower(response.column, 1, squares.rows);
    }
    if (hidden) {  // what rounding leaves in the mean dark frame is not known, but below its variance
      response.pixel.sd = std::hypot(response.pixel.sd, 1.0 / 12.0);
      response.pixel.low95 -= 1.0 / 12.0;
      response.pixel.high95 += 1.0 / 12.0;
    }
    if (trend.degree > 0) {
      const double pixels_of = squares.rows * squares.columns, n = trend.degree;
      const auto part = [&](double sum, double terms, double mean_square) {  // of a given shading
        const double left = std::max(0.0, sum - terms * mean_square);
        return Estimate{(sum - terms * mean_square) / pixels_of,
                        std::sqrt(2.0 * terms * mean_square * mean_square + 4.0 * mean_square * left) / pixels_of};
      };
      VarianceComponent shading;
      for (const Estimate& one : {part(trend.rows, n, squares.row), part(trend.columns, n, squares.column),
                                  part(trend.cross, trend.cross_terms(), squares.pixel)}) {
        shading.variance += one.value;
        shading.sd = std::hypot(shading.sd, one.sd);
      }
      shading.low95 = shading.variance - k95_sd * shading.sd;
      shading.high95 = shading.variance + k95_sd * shading.sd;
      add_rms("shading", "", shading, lines, from + ", degree " + std::to_string(trend.degree));
    }
    add_rms("prnu", "", response.pixel, pixels, from, response.pixel_sd_array);
    warn_of_shape("prnu", squares, result_.warnings);
    add_rms("prnu_row", "", response.row, lines, from, response.row_sd_array);
    add_rms("prnu_column", "", response.column, lines, from, response.column_sd_array);
  }
  const std::optional<Estimate>& rate = result_.transfer.dark;
  if (!rate || !(longest->time_s > dark->time_s)) return;
  const double charge = gain_.value * rate->value * result_.crosstalk.power.value * (longest->time_s - dark->time_s);
  const Pattern grown =
      pattern_of(plane_squares(pattern_difference(*longest, *dark).view()), {averaged(*longest), dark_stack});
  if (hidden || is_hidden_by_rounding(*longest))
    not_determined("dcnu", "", hidden_why());
  else if (rate->value > kSure_sd * rate->sd)
    add_rms("dcnu", "", grown.pixel, {charge, charge * rate->sd / rate->value}, longest->name + " less " + dark->name,
            grown.pixel_sd_array);
  else
    not_determined("dcnu", "", "the dark current is not above 3 standard deviations");
}

void Analysis::add_unknowable() {
  not_determined("transmission", "", "flat frames tell its product with the quantum efficiency only");
  not_determined("f_number", "", "flat frames do not tell it");
  not_determined("fill_factor", "", "flat frames tell its product with the quantum efficiency only");
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  constexpr std::array<std::string_view, 4> names{"determined", "upper limit", "not determined", "predicted"};
  return names[static_cast<std::size_t>(verdict)];
}

const Stack* dark_stack(const std::vector<Stack>& stacks) { return choice_of(stacks).dark; }

void drop_planes(std::vector<Stack>& stacks) {
  mark_stuck(stacks);
  mark_saturated(by_light(stacks));
  const Choice keep = choice_of(stacks);
  // A stack that is read later may show that those of this light are full: then one of less light serves.
  const double most = keep.bright != nullptr ? keep.bright->light : 0.0;
  const Choice lower = choice_of(stacks, most);
  for (Stack& s : stacks) {
    if (&s != keep.dark && &s != keep.longest && &s != keep.bright && &s != lower.bright) s.sums.pattern = mtf::Image();
    if (&s != keep.dark) s.sums.noise.pixels.clear();
  }
}

Finding finding_of(const std::string& name, const std::string& unit, const Estimate& e, const std::string& from) {
  const double half = k95_sd * e.sd;
  return {.name = name,
          .unit = unit,
          .value = e.value,
          .sd = e.sd,
          .low95 = e.value - half,
          .high95 = e.value + half,
          .from = from};
}

const Finding* Characterization::find(std::string_view name) const {
  const auto found = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.name == name; });
  return found == findings.end() ? nullptr : &*found;
}

Characterization characterize(std::vector<Stack> stacks, const CharacterizeOptions& options) {
  return Analysis(std::move(stacks), options).take();
}

}  // namespace calib
