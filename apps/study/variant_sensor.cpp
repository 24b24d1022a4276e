// SPDX-License-Identifier: Apache-2.0
#include "apps/study/variant_sensor.h"

#include <algorithm>
#include <array>
#include <limits>

#include "calib/parameter_site.h"
#include "mtf/error.h"

namespace study {
namespace {

/// Numbers of tables that are not the system's: found in the settings as given, or as their defaults.
double table_number(const mtf::io::SensorConfig& config, const std::string& path) {
  const std::size_t dot = path.find('.');
  const mtf::SettingsTable* table = mtf::find_table(config.tables, path.substr(0, dot));
  const mtf::SettingValue* value = table != nullptr ? table->find(path.substr(dot + 1)) : nullptr;
  const double* number = value != nullptr ? std::get_if<double>(value) : nullptr;
  return number != nullptr ? *number : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

bool is_spectral(std::string_view path) {
  constexpr std::array<std::string_view, 8> paths{"optics.temperature", "optics.stop_temperature", "path.transmission",
                                                  "path.radiance",      "path.air_temperature",    "scene.emissivity",
                                                  "scene.surroundings"};
  return std::find(paths.begin(), paths.end(), path) != paths.end();
}

bool is_overridable(std::string_view path) {
  const auto& numbers = radiometry::kBudgetNumbers;
  return is_spectral(path) || std::find(numbers.begin(), numbers.end(), path) != numbers.end();
}

SpectralNumbers spectral_numbers(const radiometry::Sensor& sensor, double temperature_k,
                                 const radiometry::Overrides<double>& numbers) {
  const auto& settings = sensor.settings;
  const radiometry::OpticsSettings warm = settings.optics.value_or(radiometry::OpticsSettings{});
  const double given = settings.scene ? settings.scene->surroundings_k.value_or(0.0) : 0.0;
  radiometry::Surface surface{temperature_k, sensor.emissivity, numbers("scene.surroundings", given)};
  radiometry::Path path = sensor.path;
  const auto constant = [&](std::string_view name, radiometry::Spectrum& spectrum, double most) {
    if (const double* value = numbers.find(name))
      spectrum = radiometry::constant_spectrum(std::string(name), *value, most);
  };
  constant("scene.emissivity", surface.emissivity, 1.0);
  const double* air = numbers.find("path.air_temperature");
  constant("path.transmission", path.transmission, 1.0);
  if (settings.path && (air != nullptr || settings.path->air_temperature_k))
    path = radiometry::absorbing_path(path.transmission, air != nullptr ? *air : *settings.path->air_temperature_k);
  constant("path.radiance", path.radiance, std::numeric_limits<double>::max());
  const radiometry::CameraTemperatures temperatures{numbers("optics.temperature", warm.temperature_k),
                                                    numbers("optics.stop_temperature", warm.stop_temperature_k)};
  return {radiometry::band_radiances(sensor.curves, surface, path, temperatures),
          radiometry::scene_derivative(sensor.curves, surface, path)};
}

VariantSensor load_variant(const Study& study, std::span<const int> levels) {
  VariantSensor result;
  try {
    result.config = variant(study, levels);
  } catch (const mtf::UsageError& error) {
    result.problems.emplace_back(error.what());
    return result;
  }
  result.system = result.config.system;
  if (!apps::has_chain(result.config)) {
    result.no_budget = "no [detector]";
  } else {
    try {
      result.loaded = apps::load_chain(result.config);
      require_consistent(result.system, result.loaded->sensor);
      result.system = apps::with_electron_rate(result.config.system, *result.loaded);
      result.flicker_e = radiometry::flicker_rms_e(result.system, result.loaded->sensor.settings);
      result.spectral = spectral_numbers(result.loaded->sensor, study.conditions.temperature_k, {});
      if (result.loaded->paths) result.no_budget = "the path has the range of each pixel";
    } catch (const mtf::UsageError& error) {
      result.loaded.reset();
      result.no_budget = error.what();
    }
  }
  for (const Parameter& parameter : study.parameters) {
    const auto site = calib::parameter_site(result.system, parameter.path);
    result.base.push_back(!site.numbers.empty() ? *site.numbers.front() : table_number(result.config, parameter.path));
  }
  return result;
}

}  // namespace study
