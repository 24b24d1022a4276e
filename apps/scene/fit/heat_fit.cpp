// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/fit/heat_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/light/constants.h"
#include "radiometry/thermal/ground.h"
#include "radiometry/weather/clear_sky.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Records that are missing leave longer ones.
std::optional<double> smallest_step(const std::vector<double>& time_s) {
  if (time_s.size() < 2) return std::nullopt;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < time_s.size(); ++i) step = std::min(step, time_s[i] - time_s[i - 1]);
  return step;
}

/// On equal steps, with nothing where a record is missing: the correlation of neighbours is that of neighbours in time.
MeasuredSurface on_equal_steps(const MeasuredSurface& given) {
  const std::optional<double> step = smallest_step(given.time_s);
  if (!step) return given;
  constexpr double kOffGrid = 0.01, kMostSteps = 1e6;
  const double last = (given.time_s.back() - given.time_s.front()) / *step;
  if (!(last <= kMostSteps))
    throw mtf::UsageError(one_line(given.source) + ": the shortest time between two records is " +
                          mtf::format_double(*step) + " s, of which the run has more than a million; average them");
  MeasuredSurface even{.source = given.source, .from_longwave = given.from_longwave};
  for (std::size_t i = 0; i < given.time_s.size(); ++i) {
    const double place = (given.time_s[i] - given.time_s.front()) / *step;
    if (std::abs(place - std::round(place)) > kOffGrid)
      throw mtf::UsageError(one_line(given.source) + ": the records are not equally spaced; " +
                            mtf::format_double(given.time_s[i]) + " s after the start is no multiple of " +
                            mtf::format_double(*step) + " s from the first: give equal steps, or means over them");
    while (even.time_s.size() < static_cast<std::size_t>(std::llround(place))) {
      even.time_s.push_back(given.time_s.front() + static_cast<double>(even.time_s.size()) * *step);
      even.kelvin.push_back(kMissing);
    }
    even.time_s.push_back(given.time_s[i]);
    even.kelvin.push_back(given.kelvin[i]);
  }
  return even;
}

MeasuredSurface from_longwave(const SceneFile& scene, double emissivity) {
  using enum radiometry::heat::WeatherQuantity;
  if (scene.weather.file.empty())
    throw mtf::UsageError(one_line(scene.file) +
                          ": the weather is constant and tells no temperature of the ground; write [measured] with "
                          "temperature = \"surface.csv\"");
  const radiometry::heat::Weather weather = scene_weather_records(scene).weather;
  if (!weather.has(longwave_up) || !weather.has(longwave_down))
    throw mtf::UsageError(
        one_line(scene.weather.file) +
        ": has no longwave_up beside longwave_down, which tell the temperature of the ground; or write "
        "[measured] with temperature = \"surface.csv\"");
  MeasuredSurface measured{.source = scene.weather.file, .from_longwave = true};
  const double interval =
      scene.weather.average_s > 0.0 ? scene.weather.average_s : smallest_step(weather.time_s).value_or(0.0);
  for (std::size_t i = 0; i < weather.time_s.size(); ++i) {
    const double emitted = weather[longwave_up][i] - (1.0 - emissivity) * weather[longwave_down][i];
    measured.time_s.push_back(weather.time_s[i] + to_middle(weather.stamp) * interval - scene.time.start_s);
    measured.kelvin.push_back(
        emitted > 0.0 ? std::pow(emitted / (emissivity * radiometry::kStefanBoltzmann_w_m2_k4), 0.25) : kMissing);
  }
  return measured;
}

/// The records that lie in the run. Throws UsageError where the scene has neither [measured] temperature nor weather
/// with longwave_up and longwave_down, and where no record lies in the run.
MeasuredSurface measured_surface(const SceneFile& scene, double emissivity) {
  MeasuredSurface measured;
  if (scene.measured && !scene.measured->temperature.value.empty()) {
    const radiometry::heat::Schedule& table = scene.measured->temperature;
    measured.source = table.source;
    measured.kelvin = table.value;
    for (const double t : table.time_s) measured.time_s.push_back(t - scene.time.start_s);
  } else {
    measured = from_longwave(scene, emissivity);
  }
  MeasuredSurface inside{.source = measured.source, .from_longwave = measured.from_longwave};
  for (std::size_t i = 0; i < measured.time_s.size(); ++i) {
    if (measured.time_s[i] < 0.0 || measured.time_s[i] > scene.time.end_s - scene.time.start_s) continue;
    inside.time_s.push_back(measured.time_s[i]);
    inside.kelvin.push_back(measured.kelvin[i]);
  }
  if (inside.time_s.empty())
    throw mtf::UsageError(one_line(measured.source) + ": no record lies between the start of the run, " +
                          radiometry::heat::instant_text(scene.time.start_s) + ", and its end");
  return on_equal_steps(inside);
}

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
        first_(level_run(surroundings_, scene.time.start_s, ground_of(scene), tolerance_k)) {}

  const std::vector<std::string>& warnings() const { return surroundings_.warnings; }

  std::vector<double> operator()(std::span<const double> values) const {
    std::vector<std::optional<double>> all(scene_.fits.size());
    std::vector<FitSpec> fits = scene_.fits;
    for (FitSpec& fit : fits) fit.stderr_value.reset();
    for (std::size_t i = 0; i < fitted_.size(); ++i) all[fitted_[i]] = values[i];
    const SceneResult trial = parse_scene(scene_text_with(scene_, fits, all), scene_.file);
    if (!trial.ok()) return {};
    try {
      return at_measured(
          level_run(surroundings_, scene_.time.start_s, ground_of(trial.scene), tolerance_k_, &first_.plan).kelvin);
    } catch (const mtf::Error&) {  // values that have no solution: the step is not allowed
      return {};
    }
  }

 private:
  static Material ground_of(const SceneFile& scene) {
    return material_of(scene.materials[*scene.ground->material],
                       radiometry::heat::standard_pressure_pa(scene.place.altitude_m));
  }
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
    const auto spec = std::ranges::find_if(fits, [&](const FitSpec& one) { return one.path == p.parameter.path; });
    if (spec == fits.end()) continue;
    values[static_cast<std::size_t>(spec - fits.begin())] = p.value;
    spec->stderr_value = p.knowledge == calib::Knowledge::determined ? p.stderr_value : std::nullopt;
  }
  return scene_text_with(scene, fits, values);
}

}  // namespace apps::scene
