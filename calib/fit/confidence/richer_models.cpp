// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/confidence/richer_models.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/fit/fit_report.h"
#include "mtf/components/defocus.h"
#include "mtf/components/diffraction.h"
#include "mtf/components/jitter.h"
#include "mtf/components/linear_motion.h"
#include "mtf/components/wavefront.h"
#include "mtf/words.h"

namespace calib {
namespace {

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
  const std::string name = (p.parameter.name.empty() ? p.parameter.path : p.parameter.name);
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

}  // namespace

void add_richer_models(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options,
                       const RicherFit& fit_richer, FitResult& result) {
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
    FitResult one = fit_richer(richer, all, plain, result, gain);
    if (one.status == FitStatus::stopped) break;
    if (one.status != FitStatus::converged && one.status != FitStatus::converged_model_wrong) continue;
    result.richer_models.push_back(
        {unknown.name, std::move(one.parameters), one.mtf50, gain, chance_of(gain, unknown.both_signs)});
  }
  judge(result);
}

}  // namespace calib
