// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fit/heat_fit.h"

#include <algorithm>
#include <cmath>

#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/thermal/ground.h"

namespace apps::scene {
namespace {

using mtf::io::FitSpec;

/// A change that matters of what is no size: a temperature, a flux that may have either sign.
double scale_of(const FitSpec& spec) {
  const std::string key = spec.path.substr(spec.path.rfind('.') + 1);
  return key == "temperature" || key == "flux" ? 10.0 : 0.0;
}

/// "material[0].layers[1].conductivity" -> "soil.layers[1].conductivity".
std::string name_of(const FitSpec& spec, const MaterialSection& material) {
  return material.name + spec.path.substr(spec.path.find('.'));
}

std::string place_of(const SceneFile& scene, const FitSpec& spec) {
  return one_line(scene.file) + ":" + std::to_string(spec.value_at.line) + ":" + std::to_string(spec.value_at.column) +
         ": error: " + spec.path + ": ";
}

/// Indices into scene.fits.
std::vector<std::size_t> fitted_numbers(const SceneFile& scene, bool from_longwave) {
  const std::string prefix = "material[" + std::to_string(*scene.ground->material) + "].";
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < scene.fits.size(); ++i) {
    const FitSpec& spec = scene.fits[i];
    if (!spec.fit) continue;
    if (!spec.path.starts_with(prefix))
      throw mtf::UsageError(place_of(scene, spec) +
                            "only numbers of the ground's material are fitted; write fit = false here");
    if (spec.path.ends_with(".emissivity") && from_longwave)
      throw mtf::UsageError(place_of(scene, spec) +
                            "the temperatures come from long-wave radiation by this emissivity, which therefore cannot "
                            "be fitted to them; give it, or [measured] with temperature = \"surface.csv\"");
    all.push_back(i);
  }
  if (all.empty())
    throw mtf::UsageError(one_line(scene.file) +
                          ": nothing to fit; write numbers of the ground's material as tables, such as conductivity = "
                          "{ value = \"0.3 W/m/K\", fit = true, min = \"0.05 W/m/K\", max = \"3 W/m/K\" }");
  if (all.size() > kMostFitted)
    throw mtf::UsageError(one_line(scene.file) + ": " + std::to_string(all.size()) +
                          " numbers are to be fitted, at most " + std::to_string(kMostFitted) +
                          " are; fix some with fit = false");
  return all;
}

/// The ground at the measured times, for values of the fitted numbers.
class GroundModel {
 public:
  GroundModel(const SceneFile& scene, std::vector<std::size_t> fitted, const MeasuredSurface& measured,
              double tolerance_k)
      : scene_(scene),
        fitted_(std::move(fitted)),
        measured_(measured),
        tolerance_k_(tolerance_k),
        surroundings_(surroundings_of(scene, HeatOptions{}.directions, 1.0)),
        first_(level_run(surroundings_, scene.time.start_s, material_of(scene.materials[*scene.ground->material]),
                         tolerance_k)) {}

  const std::vector<std::string>& warnings() const { return surroundings_.warnings; }

  std::vector<double> operator()(std::span<const double> values) const {
    std::vector<std::optional<double>> all(scene_.fits.size());
    std::vector<FitSpec> fits = scene_.fits;
    for (FitSpec& fit : fits) fit.stderr_value.reset();
    for (std::size_t i = 0; i < fitted_.size(); ++i) all[fitted_[i]] = values[i];
    const SceneResult trial = parse_scene(scene_text_with(scene_, fits, all), scene_.file);
    if (!trial.ok()) return {};
    try {
      const Material surface = material_of(trial.scene.materials[*scene_.ground->material]);
      return at_measured(level_run(surroundings_, scene_.time.start_s, surface, tolerance_k_, &first_.plan).kelvin);
    } catch (const mtf::Error&) {  // values that have no solution: the step is not allowed
      return {};
    }
  }

 private:
  std::vector<double> at_measured(const std::vector<double>& of_node) const {
    const std::vector<double>& t = surroundings_.time_s;
    std::vector<double> all;
    for (const double when : measured_.time_s) {
      const auto after = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), when) - t.begin());
      const std::size_t k = std::clamp<std::size_t>(after, 1, t.size() - 1);
      const double part = std::clamp((when - t[k - 1]) / (t[k] - t[k - 1]), 0.0, 1.0);
      all.push_back(std::lerp(of_node[k - 1], of_node[k], part));
    }
    return all;
  }

  const SceneFile& scene_;
  std::vector<std::size_t> fitted_;
  const MeasuredSurface& measured_;
  double tolerance_k_;
  Surroundings surroundings_;
  LevelRun first_;  ///< at the numbers of the file; its plan is that of all
};

}  // namespace

HeatFit fit_heat(const SceneFile& scene, const HeatFitOptions& options) {
  if (!scene.ground || !scene.ground->material || scene.ground->temperature)
    throw mtf::UsageError(one_line(scene.file) +
                          ": a fit compares the ground with what was measured; write [ground] with a material");
  require_files(scene);
  const MaterialSection& material = scene.materials[*scene.ground->material];
  HeatFit fit;
  fit.measured = measured_surface(scene, material.emissivity.value);
  const std::vector<std::size_t> fitted = fitted_numbers(scene, fit.measured.from_longwave);
  const GroundModel model(scene, fitted, fit.measured, options.tolerance_k);
  fit.warnings = model.warnings();
  std::vector<calib::SeriesParameter> parameters;
  for (const std::size_t i : fitted) {
    const FitSpec& spec = scene.fits[i];
    parameters.push_back({.parameter = {.path = spec.path,
                                        .name = name_of(spec, material),
                                        .unit = spec.unit,
                                        .min = spec.min,
                                        .max = spec.max,
                                        .prior = spec.prior},
                          .start = spec.value,
                          .lo = *spec.min,
                          .hi = *spec.max,
                          .scale = scale_of(spec)});
  }
  const calib::Series series{fit.measured.kelvin, scene.measured ? scene.measured->sd_k : std::nullopt};
  fit.series = calib::fit_series(series, parameters, [&](std::span<const double> values) { return model(values); },
                                 {.threads = options.threads, .progress = options.progress});
  fit.warnings.insert(fit.warnings.end(), fit.series.warnings.begin(), fit.series.warnings.end());
  const std::vector<double>& t = fit.measured.time_s;
  const double step = t.size() > 1 ? (t.back() - t.front()) / static_cast<double>(t.size() - 1) : 0.0;
  if (fit.series.phi > 0.0) fit.correlation_time_s = -step / std::log(fit.series.phi);
  return fit;
}

std::string fitted_scene_text(const SceneFile& scene, const HeatFit& fit) {
  std::vector<FitSpec> fits = scene.fits;
  std::vector<std::optional<double>> values(fits.size());
  for (const calib::FittedParameter& p : fit.series.parameters) {
    const auto spec =
        std::find_if(fits.begin(), fits.end(), [&](const FitSpec& one) { return one.path == p.parameter.path; });
    if (spec == fits.end()) continue;
    values[static_cast<std::size_t>(spec - fits.begin())] = p.value;
    spec->stderr_value = p.knowledge == calib::Knowledge::determined ? p.stderr_value : std::nullopt;
  }
  return scene_text_with(scene, fits, values);
}

}  // namespace apps::scene
