// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_warnings.h"

#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "mtf/components/footprint.h"
#include "mtf/words.h"
#include "radiometry/chain/sensor_numbers.h"

namespace apps {
namespace {

mtf::io::Diagnostic warning_at(std::string path, std::string text) {
  return {.error = false, .position = {}, .path = std::move(path), .text = std::move(text)};
}

struct FootprintArea {
  std::string label;
  double width_um = 0.0, height_um = 0.0;
  double of_pitch = 1.0;  ///< its area over that of the pitch
};

/// "14 x 15 um".
std::string size_words(double width_um, double height_um) {
  return mtf::three_digits(width_um) + " x " + mtf::three_digits(height_um) + " um";
}
std::vector<FootprintArea> footprint_areas(const mtf::System<double>& system) {
  std::vector<FootprintArea> areas;
  const auto context = system.context();
  const double cell_um2 = system.frame.pitch_x_um * system.frame.pitch_y_um;
  for (const auto& entry : system.list(mtf::Stage::presample))
    if (const auto* footprint = entry.component.get_if<mtf::Footprint<double>>()) {
      const double width_um = 1e3 * footprint->width_mm(mtf::Axis::x, context);
      const double height_um = 1e3 * footprint->width_mm(mtf::Axis::y, context);
      areas.push_back({entry.label, width_um, height_um, width_um * height_um / cell_um2});
    }
  return areas;
}

/// The active area of a pixel says how much light it takes and what its MTF is; two keys of a file state it.
std::vector<mtf::io::Diagnostic> fill_factor_warnings(const mtf::System<double>& system, double fill_factor) {
  std::vector<mtf::io::Diagnostic> warnings;
  for (const FootprintArea& other : footprint_areas(system))
    if (std::abs(other.of_pitch - fill_factor) > 1e-6 * fill_factor)
      warnings.push_back(warning_at("detector.fill_factor",
                                    mtf::three_digits(fill_factor) + " here, " + mtf::three_digits(other.of_pitch) +
                                        " in \"" + other.label +
                                        "\" of [[presample]]: both are the active area of a pixel over that of the "
                                        "pitch, here for its light, there for its MTF; give both the same value"));
  return warnings;
}

/// Of a photon detector the two may differ: microlenses fill the pitch, a quantum efficiency may be that of the cell.
std::vector<mtf::io::Diagnostic> light_area_notes(const mtf::System<double>& system,
                                                  const radiometry::DetectorSettings& detector) {
  std::vector<mtf::io::Diagnostic> notes;
  if (detector.square && detector.height_um && !detector.width_um) return notes;  // refused
  radiometry::SensorSettings settings;
  settings.detector = detector;
  const radiometry::Pixel<double> pixel = radiometry::pixel_numbers<double>(system, settings);
  const double width_um = pixel.width_um, height_um = pixel.height_um;
  const double of_pitch = width_um * height_um / (system.frame.pitch_x_um * system.frame.pitch_y_um);
  const std::string key = detector.width_um ? "detector.width" : detector.height_um ? "detector.height" : "detector";
  for (const FootprintArea& other : footprint_areas(system)) {
    if (std::abs(other.of_pitch - of_pitch) <= 1e-6 * of_pitch) continue;
    mtf::io::Diagnostic note = warning_at(
        key, "detector area " + size_words(width_um, height_um) + ", footprint " +
                 size_words(other.width_um, other.height_um) + " (\"" + other.label +
                 "\" of [[presample]]): the first takes the light, the second blurs it; give [detector] width and "
                 "height and the footprint one size, unless microlenses or the quantum efficiency make up for the "
                 "difference");
    note.remark = true;
    notes.push_back(std::move(note));
  }
  return notes;
}

/// One side of the active area alone, which newer files read otherwise.
std::vector<mtf::io::Diagnostic> one_side_warnings(const mtf::Frame<double>& frame,
                                                   const mtf::SettingsTable& detector) {
  const mtf::SettingValue *const width = detector.find("width"), *const height = detector.find("height");
  if (radiometry::width_is_square(detector) || (width == nullptr) == (height == nullptr)) return {};
  if (width != nullptr && std::get<double>(*width) == frame.pitch_y_um) return {};  // a square in both
  return {warning_at(width != nullptr ? "detector.width" : "detector.height",
                     "given alone, the other side is the pitch in this file, which says schema = 1; from schema = 2 "
                     "on width alone is a square; give width and height")};
}

/// With counts_per_kelvin nobody has said what a count is in volts.
std::vector<mtf::io::Diagnostic> invented_volts_warnings(const std::vector<mtf::SettingsTable>& tables) {
  std::vector<mtf::io::Diagnostic> warnings;
  for (const mtf::TableInfo& table : radiometry::sensor_tables())
    for (const mtf::FieldInfo& row : table.settings) {
      const mtf::SettingsTable* given = find_table(tables, table.name);
      if (given == nullptr || row.dimension != mtf::Dimension::voltage) continue;
      const mtf::SettingValue* value = given->find(row.name);
      const double* volts = value != nullptr ? std::get_if<double>(value) : nullptr;
      if (volts == nullptr || *volts == 0.0) continue;
      warnings.push_back(warning_at(std::string(table.name) + "." + std::string(row.name),
                                    "in volts beside detector.counts_per_kelvin, which leaves open how many volts a "
                                    "count is and calls it 1 uV, so that this is taken for " +
                                        mtf::three_digits(1e6 * *volts) +
                                        " counts; give it as counts x 1 uV, or responsivity and adc.volts_per_count "
                                        "in place of counts_per_kelvin"));
    }
  return warnings;
}

}  // namespace

std::vector<mtf::io::Diagnostic> chain_warnings(const mtf::io::SensorConfig& config) {
  std::vector<mtf::io::Diagnostic> warnings = atmosphere_warnings(config);
  const mtf::SettingsTable* lag = find_table(config.tables, "lag");
  const mtf::SettingValue* given = lag != nullptr ? lag->find("time_constant") : nullptr;
  const auto moving = radiometry::moving_bolometer(config.system);
  const auto add = [&](std::vector<mtf::io::Diagnostic> more) {
    for (mtf::io::Diagnostic& warning : more) warnings.push_back(std::move(warning));
  };
  const mtf::SettingsTable* table = find_table(config.tables, "detector");
  auto detector =
      table != nullptr ? std::optional(radiometry::from_table<radiometry::DetectorSettings>(*table)) : std::nullopt;
  if (detector) {
    add(one_side_warnings(config.system.frame, *table));
    detector->square = radiometry::width_is_square(*table);
  }
  if (detector && detector->kind == radiometry::DetectorKind::photon) add(light_area_notes(config.system, *detector));
  if (detector && detector->kind == radiometry::DetectorKind::thermal) {
    const double tau_s = given != nullptr ? std::get<double>(*given) : moving ? moving->time_constant_s : 0.0;
    const auto thermal = radiometry::from_table<radiometry::ThermalSettings>(*table);
    if (std::string text = bandwidth_warning(thermal, tau_s); !text.empty())
      warnings.push_back(warning_at("detector.noise_bandwidth", std::move(text)));
    if (thermal.fill_factor) add(fill_factor_warnings(config.system, *thermal.fill_factor));
    if (thermal.counts_per_k) add(invented_volts_warnings(config.tables));
    return warnings;  // [lag] beside a bolometer that moves is refused
  }
  if (given == nullptr || !moving) return warnings;
  const double lag_s = std::get<double>(*given), other_s = moving->time_constant_s;
  const bool same = std::abs(other_s - lag_s) <= 1e-6 * lag_s;
  const auto milliseconds = [](double s) { return mtf::significant(1e3 * s, 6) + " ms"; };
  warnings.push_back(
      warning_at("lag.time_constant",
                 milliseconds(lag_s) + " here, " + (same ? "the same" : milliseconds(other_s)) + " in \"" +
                     moving->label + "\" of [[presample]]: both are the thermal lag of the detector" +
                     (same ? "" : ", which has one time constant") +
                     ", and a sequence whose frames show the motion counts it twice; keep [lag] for such sequences, "
                     "the component for single images, curves and budgets" +
                     (same ? "" : ", unless one of them is another effect")));
  return warnings;
}

}  // namespace apps
