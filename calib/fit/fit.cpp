// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit.h"

#include <algorithm>
#include <cmath>

#include "calib/fit/confidence/fit_intervals.h"
#include "calib/fit/confidence/mirrors.h"
#include "calib/fit/confidence/profile.h"
#include "calib/fit/confidence/richer_models.h"
#include "calib/fit/fit_build.h"
#include "calib/fit/fit_rounds.h"
#include "mtf/units.h"

namespace calib {
namespace {

/// Tells the caller how far the work is, about: in steps of the minimiser.
class Progress {
 public:
  Progress(const FitOptions& options, double steps) : options_(&options), steps_(steps) {}
  bool stopped() const { return stopped_; }
  std::function<bool()> asks() {
    if (!options_->progress) return {};
    return [this] {
      stopped_ = stopped_ || !options_->progress(std::min(0.99, ++done_ / steps_));
      return !stopped_;
    };
  }

 private:
  const FitOptions* options_;
  double steps_ = 1.0, done_ = 0.0;
  bool stopped_ = false;
};

/// The solution as errors of functions see it: at a flat point, where first derivatives tell nothing, they are those of
/// the place next to it where the parameter acts, at which the problem then is.
Solved where_it_acts(FitProblem& problem, const Solved& solved, std::span<const FlatPoint> flat) {
  Solved there{.problem = &problem, .condition = solved.condition, .angle_rad = solved.angle_rad};
  there.identified = solved.identified;
  const std::vector<double> x = problem.x;
  for (const FlatPoint& f : flat) problem.x[f.parameter] = f.off_point(problem.x[f.parameter]);
  if (problem.x == x || !problem.apply()) return there;
  const std::vector<Eigen::MatrixXd> normals = problem.normals();
  there.identified =
      identify(information_of(problem, normals, solved.scores, solved.noise_factor).matrix, solved.reference);
  return there;
}

void report_mtf(FitProblem& problem, const Solved& solved, std::span<const FlatPoint> flat, FitResult& result) {
  for (int i = 0; i < kCurveSamples; ++i) result.frequency_cy_px.push_back(i * kCurveStep_cy_px);
  const std::vector<Functional> h = mtf_of(solved, result.frequency_cy_px);
  for (const Functional& m : h) result.mtf.push_back(m.value);
  const double variance = equivalent_variance(solved).value;
  // The difference from another polynomial estimates the error of the extraction.
  const double numerical = std::abs(variance - equivalent_variance(solved, 6).value);
  std::optional<double> half;
  double slope = 0.0;
  for (std::size_t k = 1; k < h.size() && !half; ++k) {
    if (!(h[k - 1].value >= 0.5 && h[k].value < 0.5)) continue;
    // The secant, refined on the curve itself.
    double lo = result.frequency_cy_px[k - 1], hi = result.frequency_cy_px[k];
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (lo + hi);
      const std::vector<PixelFreq> at = along(solved.angle_rad, {&middle, 1});
      (problem.sensors->modulus(solved.condition, at).front() >= 0.5 ? lo : hi) = middle;
    }
    half = lo;
    slope = std::abs(h[k].value - h[k - 1].value) / kCurveStep_cy_px;
  }
  const std::vector<double> x = problem.x;
  const Solved there = where_it_acts(problem, solved, flat);
  for (const Functional& m : mtf_of(there, result.frequency_cy_px)) result.mtf_sd.push_back(sd_of(there, m));
  result.equivalent_variance_px2 = {variance, std::hypot(sd_of(there, equivalent_variance(there)), numerical)};
  if (half) result.mtf50 = {*half, sd_of(there, mtf_of(there, {&*half, 1}).front()) / slope};
  problem.x = x;
  problem.apply();
}

std::string name_of(const FitParameter& parameter) { return parameter.name.empty() ? parameter.path : parameter.name; }

std::string rounded(double value) { return mtf::format_double(std::round(10.0 * value) / 10.0); }

/// What holds the fit off the minimum of the data: bounds, priors, a start from which nothing can be seen.
void report_obstacles(const Solved& solved, FitResult& result) {
  constexpr double kClearly_sd = 4.0, kFar_chi2 = 4.0, kNoContrast = 0.02;
  constexpr std::size_t kLow = 20;  // 0.1 cycles/px
  std::string held;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const FittedParameter& p = result.parameters[i];
    if (p.knowledge == Knowledge::at_bound && p.pressed_sd > kClearly_sd)
      held = "the " + std::string(p.limit_is_upper ? "lower" : "upper") + " bound of " + name_of(p.parameter) +
             " keeps the fit from its minimum: the data want " + (p.limit_is_upper ? "less" : "more") +
             "; move it, or look for what the model lacks";
    if (p.knowledge == Knowledge::interval && p.pressed_sd > kClearly_sd)
      held = name_of(p.parameter) + " is 0, where it does nothing, and the data want less by " + rounded(p.pressed_sd) +
             " sd; look for what the model lacks";
    if (p.parameter.prior && p.knowledge != Knowledge::not_determined) {
      const auto [mean, width] = *p.parameter.prior;
      // The variance of value - mean: v_prior - v, or v_prior - 2 v / ratio + v where pixels share their noise.
      const double free = width * width - p.linear_sd * p.linear_sd * (2.0 / solved.variance_ratio[i] - 1.0);
      const double off = std::abs(p.value - mean) / std::sqrt(std::max(free, 1e-6 * width * width));
      if (off > kClearly_sd)
        held = "the prior of " + name_of(p.parameter) + " contradicts the data by " + rounded(off) +
               " sd; check its mean and sd";
    }
    if (held.empty()) continue;
    result.warnings.push_back(held);
    if (result.status == FitStatus::converged_model_wrong) result.reason = held + "; " + result.reason;
    held.clear();
  }
  const bool unknown = std::all_of(result.parameters.begin(), result.parameters.end(),
                                   [](const FittedParameter& p) { return p.knowledge == Knowledge::not_determined; });
  const bool done = result.status == FitStatus::converged || result.status == FitStatus::converged_model_wrong;
  if (!done || !unknown || result.chi2_per_dof < kFar_chi2 || result.mtf[kLow] > kNoContrast) return;
  result.status = FitStatus::not_converged;
  result.reason = "the starting values blur everything, so that nothing leads away from them; start closer";
}

/// How much chi-square falls by the last parameter, in units of the noise. A structure that tables and rounding may
/// have is no gain.
double gain_of_last(FitProblem& problem, const Solved& solved, double cost) {
  const std::size_t last = problem.variables.size() - 1;
  const double noise = noise_factor_of(problem, solved) * solved.variance_ratio[last];
  const double root = rise_at(problem, last, problem.variables[last].x_of(0.0), cost, noise, {}, {});
  double contrasts = 0.0;  // in sd of the noise, their squares summed over the pixels
  for (std::size_t b = 0; b < problem.blocks.size(); ++b)
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      const double contrast_sd = problem.own[b][edge->contrast_index()] / edge->middle_sd();
      contrasts += contrast_sd * contrast_sd * static_cast<double>(edge->pixels());
    }
  return root > kStructureMatters * std::sqrt(contrasts) ? root * root : 0.0;
}

/// Where no minimum was found there is no value with an error.
void withdraw_values(FitResult& result) {
  for (FittedParameter& p : result.parameters) {
    p.knowledge = Knowledge::not_determined;
    p.stderr_value = p.limit95 = std::nullopt;
    p.interval68 = p.interval95 = std::nullopt;
    p.interval.reset();
    p.others.clear();
  }
  result.alternatives.clear();
}

/// Where `plain` is given, the edges have the gradients that they have there, and `gain` is that of the last parameter.
FitResult fit_one(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                  const FitResult* plain = nullptr, double* gain = nullptr);

FitResult fit_one(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                  const FitResult* plain, double* gain) {
  FitSetup setup = make_setup(data, parameters, options);
  FitProblem& problem = setup.problem;
  for (std::size_t i = 0; plain != nullptr && i < data.edges.size(); ++i)
    if (plain->data[i].gradients && setup.block_of[i]) add_gradients(problem, *setup.block_of[i]);
  FitResult result;
  result.warnings = setup.warnings;
  if (problem.blocks.empty()) {
    result.status = FitStatus::no_data;
    result.chi2_per_dof = result.whiteness_p = NAN;
    result.reason = setup.warnings.empty() ? "no edges, curves or spots were given" : setup.warnings.front();
    for (std::size_t i = 0; i < parameters.size(); ++i)
      result.parameters.push_back({.parameter = parameters[i], .start = setup.start[i], .value = setup.start[i]});
    result.system = data.conditions.front();
    return result;
  }

  const int starts = std::max(1, options.starts);
  constexpr double kSteps = 8.0, kProfileSteps = 120.0;  // of a run, of a profile
  Progress progress(options, kSteps * (starts + 1) +
                                 (options.profile ? kProfileSteps * static_cast<double>(parameters.size()) : 0.0));
  Solved solved{.problem = &problem};
  const MinimiseOptions how{options.robust, starts, progress.asks()};
  Solution solution = minimise(problem, solved, how);
  judge(solved, parameters);
  std::vector<FlatPoint> flat;
  std::vector<Mirror> mirrors;
  if (solution.converged) flat = flat_points(problem, solved);
  const std::vector<double> found = problem.x;
  if (leave_flat_points(problem, solved, flat, solution, how)) judge(solved, parameters);
  if (solution.converged) mirrors = mirrored_minima(problem, solved, solution, parameters, how);
  if (problem.x != found) flat = flat_points(problem, solved);
  set_apart(solved, flat);
  result.iterations = solution.iterations;
  result.starts_agreeing = solution.agreeing;
  result.status = solution.stopped     ? FitStatus::stopped
                  : solution.converged ? FitStatus::converged
                                       : FitStatus::not_converged;
  if (solution.stopped)
    result.reason = "stopped before the fit had converged; the values are those of the last step";
  else if (!solution.converged)
    result.reason = "no minimum was found within the allowed steps; start closer, set bounds, or ask for more starts";

  for (std::size_t b = 0; b < problem.blocks.size(); ++b)
    if (const auto* edge = std::get_if<EdgeBlock>(&problem.blocks[b])) {
      if (solved.normals_rad.empty()) {
        solved.condition = edge->condition();
        solved.angle_rad = edge->curve(problem.own[b]).angle_rad;
      }
      solved.normals_rad.push_back(edge->curve(problem.own[b]).angle_rad);
    }
  result.not_separable = null_directions(problem, solved, parameters);
  result.parameters = fitted_parameters(solved, parameters, setup.start);
  result.correlation = correlations(solved);
  report_mtf(problem, solved, flat, result);
  if (options.residual_otf) result.residual_otf.assign(result.frequency_cy_px.size(), 0.0);
  report_data(data, setup.block_of, solved, result);
  if (solution.converged) {
    const bool bent = report_squares(problem, solved, solution.cost, progress.asks(), result);
    const bool judge = bent || !flat.empty();
    if (options.profile || judge)
      report_intervals(problem, solved, flat, judge, solution.cost, mirrors, progress.asks(), result);
    report_mirrors(problem, solved, mirrors, flat, result);
    if (gain != nullptr) *gain = gain_of_last(problem, solved, solution.cost);
  }
  report_obstacles(solved, result);
  if (progress.stopped() && result.status != FitStatus::stopped) {
    result.status = FitStatus::stopped;
    result.reason = "stopped; what had been finished is given";
  }
  if (result.status != FitStatus::converged && result.status != FitStatus::converged_model_wrong)
    withdraw_values(result);
  // The system last: it shares its components with the sensors, which stay as they are. Bounds at zero are exact.
  std::vector<double> values;
  for (const FittedParameter& p : result.parameters) values.push_back(p.value);
  setup.sensors->set(values);
  result.system = setup.sensors->system(0);
  return result;
}

}  // namespace

std::string_view knowledge_name(Knowledge knowledge) {
  constexpr std::array<std::string_view, 6> kNames{"determined",     "at_bound", "prior_only",
                                                   "not_determined", "interval", "ambiguous"};
  return kNames[static_cast<std::size_t>(knowledge)];
}
std::string_view status_name(FitStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"converged", "converged_model_wrong", "not_converged", "no_data",
                                                   "stopped"};
  return kNames[static_cast<std::size_t>(status)];
}

FitResult fit(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options) {
  FitResult result = fit_one(data, parameters, options);
  const auto fit_richer = [](const FitData& richer, std::span<const FitParameter> more, const FitOptions& plain_options,
                             const FitResult& plain,
                             double& gain) { return fit_one(richer, more, plain_options, &plain, &gain); };
  if (options.richer_models) add_richer_models(data, parameters, options, fit_richer, result);
  return result;
}

}  // namespace calib
