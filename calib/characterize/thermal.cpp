// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/thermal.h"

#include <algorithm>
#include <cmath>

#include "calib/characterize/defect_pixels.h"
#include "calib/characterize/rounding.h"
#include "calib/fit/confidence/adequacy.h"
#include "calib/fit/fit_report.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;
using radiometry::kT, radiometry::kV, radiometry::kH, radiometry::kTv, radiometry::kTh, radiometry::kVh,
    radiometry::kTvh;

double squared(double x) { return x * x; }

/// A stack that counts in the line.
struct LinePoint {
  const Stack* stack = nullptr;
  double variance = 0.0;  ///< random, of the mean
};

/// Standard deviations of a number that is linear in the means.
struct NumberErrors {
  double random = 0.0, systematic = 0.0;
};

/// The line of the means over the radiance.
class MeanLine {
 public:
  MeanLine(std::vector<LinePoint> points, const ThermalOptions& options)
      : points_(std::move(points)), options_(options) {
    double ratio = 0.0;
    for (const LinePoint& one : points_) {
      const radiometry::MeanSquares& squares = one.stack->sums.squares;
      ratio += squares.dof(kT) * squares.value[kT] / squares.value[kTvh];
      dof_ += squares.dof(kT);
    }
    for (LinePoint& one : points_) {
      const radiometry::MeanSquares& squares = one.stack->sums.squares;
      const double v = squares.value[kTvh], pixels = squares.rows * squares.columns;
      one.variance = ratio / dof_ * v / (squares.frames * pixels) + rounding_of(*one.stack) / pixels;
    }
    for (int round = 0; round < 3; ++round) fit();  // the error of a temperature counts by the slope
  }

  const std::vector<LinePoint>& points() const { return points_; }
  double slope() const { return slope_; }
  double dof() const { return dof_; }
  double count(double radiance) const { return middle_ + slope_ * (radiance - center_); }
  /// With the errors of the temperatures, which are independent as the means are.
  double variance(const LinePoint& one) const {
    return one.variance + squared(slope_ * one.stack->light_per_k * options_.temperature_sd_k);
  }
  NumberErrors errors_of_slope() const { return errors(0.0, 1.0); }
  NumberErrors errors_of_count(double radiance) const { return errors(1.0, radiance - center_); }

 private:
  void fit() {
    double sum = 0.0, radiance = 0.0, mean = 0.0, products = 0.0;
    for (const LinePoint& one : points_) {
      const double w = 1.0 / variance(one);
      sum += w;
      radiance += w * one.stack->light;
      mean += w * one.stack->sums.mean;
    }
    weight_ = sum;
    center_ = radiance / sum;
    middle_ = mean / sum;
    spread_ = 0.0;
    for (const LinePoint& one : points_) {
      const double x = (one.stack->light - center_) / variance(one);
      spread_ += x * (one.stack->light - center_);
      products += x * (one.stack->sums.mean - middle_);
    }
    slope_ = products / spread_;
  }

  /// Of a x the mean in the middle + b x the slope.
  NumberErrors errors(double a, double b) const {
    double random = 0.0, temperatures = 0.0, emissivity = 0.0;
    for (const LinePoint& one : points_) {
      const double weight = (a / weight_ + b * (one.stack->light - center_) / spread_) / variance(one);
      random += squared(weight) * one.variance;
      temperatures += squared(weight * one.stack->light_per_k * options_.temperature_sd_k);
      emissivity += weight * one.stack->light_per_emissivity * options_.emissivity_sd;
    }
    return {std::sqrt(random), slope_ * std::sqrt(temperatures + squared(emissivity))};
  }

  std::vector<LinePoint> points_;
  const ThermalOptions& options_;
  double dof_ = 0.0, slope_ = 0.0, middle_ = 0.0, center_ = 0.0, weight_ = 0.0, spread_ = 1.0;
};

/// The stacks that are not clipped, by radiance. Why others are left out goes to `warnings`.
std::vector<LinePoint> line_points(const std::vector<Stack>& stacks, std::vector<std::string>& warnings) {
  std::vector<LinePoint> points;
  for (const Stack& one : stacks) {
    if (!one.is_usable()) {
      warnings.push_back(left_out_words(one));
      continue;
    }
    if (is_hidden_by_rounding(one))
      throw mtf::UsageError(one.name + ": " + hidden_words() +
                            ": rounding hides the noise; raise the gain of the camera");
    points.push_back({&one});
  }
  const std::string left = warnings.empty() ? "" : " (" + warnings.front() + ")";
  const bool differ = !points.empty() && points.back().stack->light > points.front().stack->light;
  if (const std::string few = too_few_radiances(points.size(), differ); !few.empty()) throw mtf::UsageError(few + left);
  return points;
}

class FindingList {
 public:
  FindingList(double dof, Characterization& result)
      : student_(std::sqrt(f_quantile(0.95, 1.0, dof))), found_(result.findings), warnings_(result.warnings) {}

  void add_value(const std::string& name, const std::string& unit, double value, NumberErrors sd,
                 const std::string& from) {
    const double half = half95(sd);
    found_.push_back({.name = name,
                      .unit = unit,
                      .value = value,
                      .sd = sd.random,
                      .low95 = value - half,
                      .high95 = value + half,
                      .sd_systematic = sd.systematic,
                      .from = from});
  }
  /// The root of a variance in counts^2 over a number of counts of that relative error.
  void add_rms(const std::string& name, const std::string& unit, const VarianceComponent& c, double counts,
               NumberErrors relative, const std::string& from) {
    const auto root = [&](double v) { return std::sqrt(std::max(0.0, v)) / counts; };
    Finding f{.name = name, .unit = unit, .value = root(c.variance), .from = from};
    const double half = f.value * half95(relative);
    f.verdict = c.low95 > 0.0 ? Verdict::determined : Verdict::upper_limit;
    f.low95 = std::max(0.0, f.value - std::hypot(f.value - root(c.low95), half));
    f.high95 = f.value + std::hypot(root(c.most()) - f.value, half);
    if (f.value > 0.0) f.sd = std::hypot(c.sd / (2.0 * f.value * squared(counts)), f.value * relative.random);
    f.sd_systematic = f.value * relative.systematic;
    found_.push_back(std::move(f));
  }
  std::vector<std::string>& warnings() { return warnings_; }

 private:
  double half95(NumberErrors sd) const { return std::hypot(student_ * sd.random, k95_sd * sd.systematic); }

  double student_;
  std::vector<Finding>& found_;
  std::vector<std::string>& warnings_;
};

constexpr std::array<const char*, radiometry::kCubeParts> kNoiseNames{"noise_t",  "noise_v",  "noise_h",  "noise_tv",
                                                                      "noise_th", "noise_vh", "noise_tvh"};

/// The stack nearest to the reference, and what is found of its pixels.
struct Nearest {
  const Stack* stack = nullptr;
  PlaneSquares fixed{};
  DefectSums defects{};
  BlinkingPixels blinking{};
};
Nearest add_noise(const MeanLine& line, const Stack& nearest, const ThermalOptions& options, NumberErrors slope,
                  double offset, FindingList& findings) {
  const auto& points = line.points();
  const Stack &cold = *points.front().stack, &hot = *points.back().stack;
  const mtf::Image difference = pattern_difference(hot, cold);
  PlaneSquares plane = plane_squares(difference.view());
  Nearest found{.stack = &nearest, .fixed = plane_squares(nearest.sums.pattern.view())};
  const bool fine = !(rounding_of(nearest) > 1e-4);
  if (fine) found.blinking = blinking_pixels(nearest.sums, found.fixed, 0.0, 0.0);
  const bool blinks = found.blinking.found();
  if (blinks) {  // their mean frames are other ones in each stack
    plane = plane_squares(difference.view(), 0, found.blinking.restless);
    found.fixed = plane_squares(nearest.sums.pattern.view(), 0, found.blinking.restless);
  }
  found.defects = defect_sums(found.fixed, &plane, hot.sums.mean - cold.sums.mean,
                              blinks ? found.blinking.restless : std::set<std::int64_t>(), true);
  const radiometry::MeanSquares& squares = nearest.sums.squares;
  VarianceComponent quiet = variance_component(squares, kTvh);  // without pixels that blink, which are found apart
  if (blinks) {
    StackSummary rest{.squares = squares, .variances = nearest.sums.variances, .rows_apart = nearest.sums.rows_apart};
    leave_out(rest, found.blinking.restless, found.blinking.slowness());
    radiometry::MeanSquares others = squares;
    others.value[kTvh] -= rest.apart.value;
    quiet = variance_component(others, kTvh);
    widen(quiet, rest.apart.sd);
    found.blinking.unseen_count = found.blinking.unseen_variance(squares.frames) > quiet.sd;
  }
  const double counts_per_mk = 1e-3 * line.slope() * options.radiance_per_k;
  findings.add_rms("netd", "mK", quiet, counts_per_mk, slope, nearest.name);
  for (const radiometry::CubePart part : {kT, kV, kH, kTv, kTh, kVh, kTvh})
    findings.add_rms(kNoiseNames[part], "mK", variance_component(squares, part), counts_per_mk, slope, nearest.name);

  const VarianceComponent response =
      pattern_of(plane, {{hot.sums.squares, rounding_of(hot)}, {cold.sums.squares, rounding_of(cold)}}).pixel;
  const double span = line.slope() * (hot.light - cold.light), signal = nearest.sums.mean - offset;
  findings.add_rms("prnu", "", response, span, {slope.random, 0.0}, hot.name + " less " + cold.name);
  warn_of_shape("noise_vh", found.fixed, findings.warnings());
  warn_of_shape("prnu", plane, findings.warnings());

  // What the responses of the pixels make of the signal is no offset; the distances of both limits add as squares.
  const double scale = squared(signal / span);
  const VarianceComponent pixels = pattern_of(found.fixed, {{squares, rounding_of(nearest)}}).pixel;
  VarianceComponent rest{.variance = pixels.variance - scale * response.variance,
                         .sd = std::hypot(pixels.sd, scale * response.sd)};
  rest.low95 =
      rest.variance - std::hypot(pixels.variance - pixels.low95, scale * (response.high95 - response.variance));
  rest.high95 =
      rest.variance + std::hypot(pixels.high95 - pixels.variance, scale * (response.variance - response.low95));
  findings.add_rms("dsnu", "mK", rest, counts_per_mk, slope,
                   "noise_vh without defects, less what prnu makes of " + significant(signal, 3) + " counts");
  return found;
}

void judge(const MeanLine& line, double misfit_p, Characterization& result) {
  PhotonTransfer& fit = result.transfer;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const LinePoint* worst = nullptr;
  double worst_z = 0.0;
  for (const LinePoint& one : line.points()) {
    const double model = line.count(one.stack->light);
    const double z = (one.stack->sums.mean - model) / std::sqrt(line.variance(one));
    fit.levels.push_back({kNone, kNone, model, kNone, z, kNone, kNone});
    fit.chi2 += z * z;
    if (worst == nullptr || std::abs(z) > std::abs(worst_z)) worst = &one, worst_z = z;
  }
  fit.dof = static_cast<int>(line.points().size()) - 2;
  fit.p = f_tail(fit.chi2 / std::max(1, fit.dof), fit.dof, line.dof());
  fit.converged = true;
  result.misfit = fit.p < misfit_p;
  if (result.misfit)
    result.misfit_reason = "chi-square " + significant(fit.chi2, 4) + " with " + std::to_string(fit.dof) +
                           " degrees of freedom, p = " + significant(fit.p, 2) +
                           "; the blackbody that disagrees most is " + worst->stack->name + " (" +
                           significant(worst_z, 2) +
                           " standard deviations): the counts are not linear in the radiance of this band, or the "
                           "temperatures err by more than temperature_sd";
}

/// The noise of most pixels does not fall with the radiance, but for what bends and for chance: where it does, they are
/// full.
void mark_full(std::vector<Stack>& stacks) {
  constexpr double kFalls = 0.85, kChance_sd = 7.0;  // of the largest variance of those with less radiance
  double largest = 0.0;
  for (Stack& stack : stacks) {
    if (!stack.is_usable()) continue;
    const double noise = typical_variance(stack.sums), chance = 2.0 / std::sqrt(stack.sums.squares.dof(kTvh));
    stack.saturates = noise < std::min(kFalls, 1.0 - kChance_sd * chance) * largest;
    largest = std::max(largest, noise);
  }
}

}  // namespace

std::string too_few_radiances(std::size_t stacks, bool differ) {
  if (differ) return "";
  return "blackbodies: " +
         (stacks < 2 ? mtf::plural(static_cast<std::int64_t>(stacks), "usable stack")
                     : "all usable stacks have one radiance") +
         "; SiTF takes two temperatures or more";
}

const Stack* nearest_stack(const std::vector<Stack>& stacks, double radiance) {
  const Stack* best = nullptr;
  const auto rank = [&](const Stack& one) { return std::pair(std::abs(one.light - radiance), one.light); };
  for (const Stack& one : stacks)
    if (one.is_usable() && (best == nullptr || rank(one) < rank(*best))) best = &one;
  return best;
}

Characterization characterize_thermal(std::vector<Stack> stacks, const ThermalOptions& options) {
  std::stable_sort(stacks.begin(), stacks.end(), [](const Stack& a, const Stack& b) { return a.light < b.light; });
  mark_stuck(stacks);
  mark_full(stacks);
  require_sound(stacks);
  Characterization result;
  result.reference_k = options.reference_k;
  const MeanLine line(line_points(stacks, result.warnings), options);
  const NumberErrors slope = line.errors_of_slope();
  if (!(line.slope() > 5.0 * slope.random))
    throw mtf::UsageError(
        "blackbodies: the counts do not rise with the radiance beyond their noise; stacks and temperatures are paired "
        "wrongly, or lie too close");
  judge(line, options.misfit_p, result);
  const NumberErrors relative{slope.random / line.slope(), slope.systematic / line.slope()};
  FindingList findings(line.dof(), result);
  const std::string from = "line through the means of " + std::to_string(line.points().size()) + " stacks";
  const double sitf = line.slope() * options.radiance_per_k, offset = line.count(-options.own_radiance);
  findings.add_value("sitf", "counts/K", sitf, {sitf * relative.random, sitf * relative.systematic},
                     from + ", at " + significant(options.reference_k, 6) + " K");
  findings.add_value("offset", "counts", offset, line.errors_of_count(-options.own_radiance), from);
  Nearest nearest = add_noise(line, *nearest_stack(stacks, options.radiance), options, relative, offset, findings);
  // Of these all errors are those of their number.
  const Estimate counts_per_mk{1e-3 * sitf, 1e-3 * sitf * std::hypot(relative.random, relative.systematic)};
  const std::string& from_nearest = nearest.stack->name;
  add_hot_pixels(nearest.defects, nearest.fixed, counts_per_mk, "mK", from_nearest, result);
  add_dead_pixels(nearest.defects, nearest.fixed.rows * nearest.fixed.columns, from_nearest, result);
  if (!(rounding_of(*nearest.stack) > 1e-4))
    add_blinking_pixels(nearest.blinking, counts_per_mk, "mK", from_nearest, result);
  result.defects = std::move(nearest.fixed.defects);
  result.dark = static_cast<int>(nearest.stack - stacks.data());
  warn_of_neighbours(*nearest.stack, result.warnings);
  add_noise_in_time(stacks, result.findings, result.warnings, nearest.blinking.found(), nearest.blinking.explained());
  for (const char* const name : {"transmission", "absorptance", "f_number"})
    result.findings.push_back({.name = name,
                               .unit = "",
                               .verdict = Verdict::not_determined,
                               .why = "blackbodies tell its product with the gain only"});

  int used = 0;
  for (const Stack& one : stacks) result.level_of.push_back(one.is_usable() ? used++ : -1);
  result.stacks = std::move(stacks);
  return result;
}

}  // namespace calib
