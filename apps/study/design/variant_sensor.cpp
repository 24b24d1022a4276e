// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/variant_sensor.h"

#include <algorithm>
#include <limits>

#include "apps/sensor/sensor_air.h"
#include "calib/fit/parameter_site.h"
#include "mtf/error.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/words.h"

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

/// A pixel has one time constant: a study that moves it in [detector] or in the component leaves two.
std::string time_constant_problem(const Study& study, const mtf::System<double>& system,
                                  const radiometry::SensorSettings& settings) {
  if (!settings.thermal || !settings.thermal->physics() || !radiometry::moving_bolometer(system)) return "";
  for (const Parameter& parameter : study.parameters)
    if (parameter.path == "detector.heat_capacity" || parameter.path == "detector.conductance" ||
        parameter.path.ends_with(".time_constant"))
      return parameter.path +
             ": the time constant of the pixels stands in [detector] and in the bolometer component, and only one of "
             "them would change; remove the component";
  return "";
}

}  // namespace

bool is_overridable(std::string_view path) {
  const auto in = [&](const auto& numbers) { return std::find(numbers.begin(), numbers.end(), path) != numbers.end(); };
  return radiometry::is_spectral(path) || in(radiometry::kBudgetNumbers) || in(radiometry::kThermalNumbers);
}

radiometry::SpectralNumbers<double> spectral_numbers(const Conditions& conditions, const radiometry::Sensor& sensor,
                                                     const radiometry::Path& path,
                                                     const radiometry::Overrides<double>& numbers) {
  return radiometry::spectral_numbers(sensor, path, conditions.temperature_k, conditions.contrast_k.value_or(0.0),
                                      numbers);
}

VariantSensor load_variant(const Study& study, std::span<const int> levels) {
  VariantSensor result;
  require_unchanged(study);
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
      if (const std::string why = time_constant_problem(study, result.system, result.loaded->sensor.settings);
          !why.empty())
        result.problems.push_back(why);
      result.system = apps::with_electron_rate(result.config.system, *result.loaded);
      result.flicker_e = radiometry::flicker_rms_e(result.system, result.loaded->sensor.settings);
      result.spectral = spectral_numbers(study.conditions, result.loaded->sensor, result.loaded->sensor.path);
      result.loaded->sensor.settings = radiometry::budget_settings(result.loaded->sensor);
      result.no_ranges = apps::air_course_gap(result.system, *result.loaded);
      if (result.loaded->paths) result.no_budget = result.no_ranges;
    } catch (const mtf::UsageError& error) {
      result.loaded.reset();
      result.no_budget = error.what();
    }
  }
  if (const auto entry = mtf::entry_by_range(result.system)) {
    const std::optional<double>& range_m = study.conditions.range_m;
    const std::string distance = range_m
                                     ? "\"" + mtf::significant(mtf::distance_at_um(result.system, 1.0 / *range_m), 4) +
                                           " um\", that of " + mtf::format_double(*range_m) + " m"
                                     : std::string("that of one range: F^2 (1/range - 1/focus)");
    result.no_focus = "presample[" + std::to_string(*entry) +
                      "].focus: a target is out of focus by its range, and this metric takes one OTF for all; give "
                      "distance = " +
                      distance + ", in place of focus and distance = \"range\"";
  }
  for (const Parameter& parameter : study.parameters) {
    const auto site = calib::parameter_site(result.system, parameter.path);
    result.base.push_back(!site.numbers.empty() ? *site.numbers.front() : table_number(result.config, parameter.path));
  }
  return result;
}

}  // namespace study
