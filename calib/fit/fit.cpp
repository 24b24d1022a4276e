// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "calib/fit/confidence/fit_intervals.h"
#include "calib/fit/confidence/mirrors.h"
#include "calib/fit/fit_build.h"
#include "calib/fit/fit_report.h"
#include "calib/fit/fit_rounds.h"
#include "mtf/components/defocus.h"
#include "mtf/components/diffraction.h"
#include "mtf/components/jitter.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/wavefront.h"
#include "mtf/words.h"

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
  Solved there{.problem = &problem, .place = solved.place, .angle_rad = solved.angle_rad};
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
      (problem.sensors->modulus(solved.place, at).front() >= 0.5 ? lo : hi) = middle;
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

/// Where `plain` is given, the edges have the gradients that they have there, and `gain` is how much chi-square falls
/// by the last parameter, from its value 0, in units of the noise.
FitResult fit_one(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                  const FitResult* plain = nullptr, double* gain = nullptr) {
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
  if (solution.converged) mirrors = mirrored_minima(problem, solved, solution, parameters, how, plain);
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
        solved.place = edge->place();
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
    const std::vector<BentSquare> bent = report_squares(problem, solved, solution.cost, progress.asks(), result);
    if (options.profile || !bent.empty() || !flat.empty())
      report_intervals(problem, solved, flat, bent, options.profile, solution.cost, mirrors, progress.asks(), result);
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

// What the errors of a fit leave out: they hold for the sensor as it was given. A lens of f/8 out of focus by 0.4 waves
// is fitted by f/14 in focus, known to 1.5 %, and the residuals do not show it where there is noise. So the fit is made
// again with one more unknown of those that sensors have and files leave out:
// - defocus, in a sensor with diffraction and no focus term or random wavefront, but for point sources in a band, which
//   take minutes;
// - jitter, where there is none;
// - motion along x or y, whichever the data look along, where there is no motion but jitter.
// What becomes of each parameter is what the data say of it where that is not known to be 0. Where chi-square falls by
// more than chance explains, the sensor does not describe the data. A fitted blur that is known by its size alone, as a
// `gaussian`, stands for all causes, and needs none of this.

using mtf::System;
using Entries = std::vector<mtf::Entry<double>>;

/// One more number of a sensor, 0 so far.
struct Unknown {
  std::string name;
  FitParameter parameter;
  std::vector<System<double>> conditions;
  bool both_signs = false;  ///< they differ: beside other aberrations
};

const Entries& presample(const System<double>& system) { return system.list(mtf::Stage::presample); }

std::string path_of(std::size_t entry, const char* field) {
  return "presample[" + std::to_string(entry) + "]." + field;
}

bool has(const System<double>& system, const std::function<bool(const mtf::Component<double>&)>& is) {
  return std::any_of(presample(system).begin(), presample(system).end(),
                     [&](const mtf::Entry<double>& entry) { return is(entry.component); });
}

/// Whether a parameter belongs to a blur of which nobody has said where it comes from.
bool stands_for_all(const System<double>& system, std::span<const FitParameter> parameters) {
  for (std::size_t k = 0; k < presample(system).size(); ++k)
    for (const FitParameter& parameter : parameters)
      if (parameter.path.starts_with(path_of(k, "")) &&
          presample(system)[k].component.part() == mtf::SensorPart::unspecified)
        return true;
  return false;
}

/// The same with a component more, whose number is `field`.
Unknown with(std::vector<System<double>> conditions, const char* name, const mtf::Component<double>& component,
             const char* field, const char* unit) {
  const std::size_t place = presample(conditions.front()).size();
  for (System<double>& system : conditions) system.add(mtf::Stage::presample, component);
  return {name,
          {.path = path_of(place, field), .name = std::string(component.kind()) + "." + field, .unit = unit},
          std::move(conditions)};
}

/// The pupil with a defocus; its number of the list stays.
std::optional<Unknown> with_defocus(std::vector<System<double>> conditions) {
  const Entries& entries = presample(conditions.front());
  const auto pupil = std::ranges::find_if(entries, [](auto& entry) { return entry.component.is_pupil(); });
  if (pupil == entries.end()) return std::nullopt;
  const auto place = static_cast<std::size_t>(pupil - entries.begin());
  const bool seidel = pupil->component.kind() == mtf::Wavefront<double>::kind;
  // Numbers over the field are named by their rows in the table of their kind.
  const auto of_pupil = [place](const mtf::FieldNumber<double>& number) { return number.entry == place; };
  if (!seidel && std::ranges::any_of(conditions.front().field.numbers, of_pupil)) return std::nullopt;
  for (System<double>& system : conditions) {
    mtf::Component<double>& component = system.list(mtf::Stage::presample)[place].component;
    if (const auto* plain = component.get_if<mtf::Diffraction<double>>()) {
      mtf::Defocus<double> defocus;
      defocus.waves = 0.0;
      defocus.f_number = plain->f_number;
      defocus.obscuration = plain->obscuration;
      defocus.wavelength_um = plain->wavelength_um;
      component = defocus;
    } else if (const auto* aberrated = component.get_if<mtf::Wavefront<double>>()) {
      constexpr std::size_t kFocusTerms = 4;
      if (aberrated->w020 || aberrated->zernike.size() >= kFocusTerms) return std::nullopt;
      mtf::Wavefront<double> wavefront = *aberrated;
      wavefront.w020 = 0.0;
      component = wavefront;
    } else {
      return std::nullopt;
    }
  }
  const char* const field = seidel ? "w020" : "waves";
  return Unknown{
      "defocus",
      {.path = path_of(place, field), .name = std::string(seidel ? "wavefront." : "defocus.") + field, .unit = ""},
      std::move(conditions),
      seidel};
}

/// Whether the data look along x, and along y.
std::array<bool, 2> axes_of(const FitData& data) {
  constexpr double kAlong = 0.5;
  std::array<bool, 2> all{!data.spots.empty(), !data.spots.empty()};
  const auto add = [&](double angle_rad) {
    all[0] = all[0] || std::abs(std::cos(angle_rad)) > kAlong;
    all[1] = all[1] || std::abs(std::sin(angle_rad)) > kAlong;
  };
  for (const EdgeData& edge : data.edges) add(edge.start.curve.angle_rad);
  for (const CurveData& curve : data.curves) add(curve.angle_deg * std::numbers::pi / 180.0);
  return all;
}

/// `conditions`: with the fitted values.
std::vector<Unknown> unknowns(const FitData& data, const std::vector<System<double>>& conditions,
                              std::span<const FitParameter> parameters) {
  const System<double>& system = conditions.front();
  std::vector<Unknown> all;
  if (stands_for_all(system, parameters)) return all;
  const auto kind = [](std::string_view name) {
    return [name](const mtf::Component<double>& component) { return component.kind() == name; };
  };
  const bool slow = system.band && !data.spots.empty();
  if (!slow && !has(system, kind("rms_wavefront")) && !has(system, kind("random_wavefront")))
    if (auto defocus = with_defocus(conditions)) all.push_back(std::move(*defocus));
  const mtf::Extent<double> none{0.0, mtf::find_unit("um")};
  if (!has(system, kind("jitter")))
    all.push_back(with(conditions, "jitter", mtf::Jitter<double>{.rms = {none, none, false}}, "rms", "um"));
  const auto moves = [](const mtf::Component<double>& component) {
    return component.part() == mtf::SensorPart::motion && component.kind() != "jitter";
  };
  if (has(system, moves)) return all;
  const auto [along_x, along_y] = axes_of(data);
  mtf::LinearMotion<double> motion{.travel = {none, none, false}};
  if (along_x) all.push_back(with(conditions, "motion along x", motion, "travel", "um"));
  motion.direction_deg.value = 90.0;
  if (along_y) all.push_back(with(conditions, "motion along y", motion, "travel", "um"));
  return all;
}

/// That noise lowers chi-square by so much with one more unknown, which can be below 0 or not.
double chance_of(double gain, bool both_signs) {
  return (both_signs ? 1.0 : 0.5) * std::erfc(std::sqrt(0.5 * std::max(0.0, gain)));
}

std::string told(const FittedParameter& p) {
  const std::string unit = p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
  const std::string name = name_of(p.parameter);
  if (p.stderr_value)
    return name + " " + mtf::significant(p.value, 4) + " +- " + mtf::significant(*p.stderr_value, 2) + unit;
  if (p.interval95)
    return name + " " + mtf::significant((*p.interval95)[0], 3) + " to " + mtf::significant((*p.interval95)[1], 3) +
           unit;
  return name + " " + std::string(knowledge_name(p.knowledge));
}

/// Where a richer model is better than chance allows.
void judge(FitResult& result) {
  const auto best = std::ranges::min_element(result.richer_models,
                                             [](const RicherModel& a, const RicherModel& b) { return a.p < b.p; });
  if (best == result.richer_models.end()) return;
  const double p = best->p * static_cast<double>(result.richer_models.size());
  if (p >= kWrongModel_p) return;
  const std::string found = "with " + best->unknown + " unknown it describes them better: chi-square falls by " +
                            mtf::significant(best->chi2_gain, 3) + " (p = " + mtf::significant(p, 1) + "), with " +
                            mtf::joined(best->parameters, told);
  result.reason = result.status == FitStatus::converged ? "the sensor does not describe the data; " + found +
                                                              "; the errors given are those of the sensor without it"
                                                        : result.reason + "; " + found;
  result.status = FitStatus::converged_model_wrong;
}

/// Adds the richer models to a fit that converged, and takes back the verdict that its model is right where one of them
/// describes the data better.
void add_richer_models(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                       FitResult& result) {
  if (result.status != FitStatus::converged && result.status != FitStatus::converged_model_wrong) return;
  std::vector<System<double>> conditions = data.conditions;
  for (System<double>& system : conditions)
    for (const FittedParameter& p : result.parameters) set_parameter(system, p.parameter.path, p.value);
  FitOptions plain = options;
  plain.starts = 1;
  plain.profile = plain.residual_otf = plain.richer_models = false;
  constexpr double kLast = 0.99;  // of the work
  if (options.progress) plain.progress = [&options](double) { return options.progress(kLast); };
  for (Unknown& unknown : unknowns(data, conditions, parameters)) {
    // As of an obscuration that the pupil of a defocus does not allow.
    const auto faulty = [](const System<double>& system) { return !system.errors().empty(); };
    if (std::ranges::any_of(unknown.conditions, faulty)) continue;
    FitData richer = data;
    richer.conditions = std::move(unknown.conditions);
    std::vector<FitParameter> all(parameters.begin(), parameters.end());
    all.push_back(unknown.parameter);
    double gain = 0.0;
    FitResult one = fit_one(richer, all, plain, &result, &gain);
    if (one.status == FitStatus::stopped) break;
    if (one.status != FitStatus::converged && one.status != FitStatus::converged_model_wrong) continue;
    result.richer_models.push_back(
        {unknown.name, std::move(one.parameters), one.mtf50, gain, chance_of(gain, unknown.both_signs)});
  }
  judge(result);
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
  if (options.richer_models) add_richer_models(data, parameters, options, result);
  return result;
}

}  // namespace calib
