// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_place.h"
#include "mtf/components/footprint.h"
#include "mtf/error.h"
#include "mtf/field/throughput.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/io/csv/tape7.h"
#include "mtf/io/image_io.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/curve_gaps.h"
#include "radiometry/stages/noise/fixed_pattern.h"

namespace apps {
namespace {

using radiometry::NumberOrFile;
using radiometry::Spectrum;

constexpr double kAny = std::numeric_limits<double>::max();

/// The last part of "detector.quantum_efficiency", which is the name of the column too.
std::string column_of(const std::string& key) { return key.substr(key.rfind('.') + 1); }

Spectrum curve_of(const NumberOrFile& value, const char* key, double most) {
  if (value.file.empty()) return radiometry::constant_spectrum(key, value.number, most);
  return at_key(key, [&] {
    mtf::io::SpectrumColumns curve = mtf::io::read_spectrum_csv(value.file, {column_of(key)});
    return radiometry::make_spectrum(value.file, std::move(curve.wavelength_um), std::move(curve.columns.front()),
                                     most);
  });
}

void add_curve(std::vector<Spectrum>& curves, const NumberOrFile& value, const char* key) {
  if (!value.file.empty()) curves.push_back(curve_of(value, key, 1.0));
}

std::shared_ptr<const mtf::Image> map_of(const std::string& file, const char* key, bool factors) {
  if (file.empty()) return nullptr;
  return at_key(key, [&] {
    mtf::io::ImageFile image = mtf::io::read_image(file, {});
    if (image.planes.size() != 1)
      throw mtf::UsageError(file + ": has " + std::to_string(image.planes.size()) + " channels; a map has one");
    if (image.integer) throw mtf::UsageError(file + ": holds whole numbers; a map is a float image (EXR)");
    if (!image.info.notes.empty())
      throw mtf::UsageError(file + ": " + image.info.notes.front() +
                            "; store the map as an OpenEXR of one image, without loss");
    radiometry::require_numbers(file, image.planes.front().view(),
                                factors ? 0.0F : std::numeric_limits<float>::lowest());
    return std::make_shared<const mtf::Image>(std::move(image.planes.front()));
  });
}

/// A tape7 of one run has the range that is given; a CSV names its own.
radiometry::PathTable table_of(const radiometry::PathSettings& settings, bool by_pixel) {
  return at_key("path.table", [&] {
    const std::string& file = settings.table;
    if (file.ends_with(".csv")) {
      mtf::io::PathColumns c = mtf::io::read_path_csv(file);
      return radiometry::PathTable(file, c.range_m, c.wavelength_um, c.transmission, c.radiance);
    }
    if (by_pixel)
      throw mtf::UsageError(file +
                            ": a tape7 has one range for each run and does not say which; for "
                            "scene.depth_channel write a CSV with a column range_m");
    const std::vector<mtf::io::Tape7Run> runs = mtf::io::read_tape7(file);
    if (runs.size() == 1 && !settings.range_m)
      throw mtf::UsageError(file + ": a tape7 does not say how long its path is; give path.range");
    if (runs.size() > 1)
      throw mtf::UsageError(file + ": holds " + std::to_string(runs.size()) +
                            " runs without their ranges; write them as a CSV with a column range_m");
    const mtf::io::PathColumns c = mtf::io::path_columns(runs, {*settings.range_m});
    return radiometry::PathTable(file, c.range_m, c.wavelength_um, c.transmission, c.radiance);
  });
}

void read_path(const radiometry::SensorSettings& settings, LoadedSensor& loaded) {
  const radiometry::PathSettings& given = *settings.path;
  const bool by_pixel = settings.scene && !settings.scene->depth_channel.name.empty();
  radiometry::Path& path = loaded.sensor.path;
  if (given.table.empty()) {
    if (by_pixel || given.range_m)
      throw mtf::UsageError(std::string(by_pixel ? "scene.depth_channel" : "path.range") +
                            ": needs path.table, which says what a path of that length does");
    const Spectrum transmission = curve_of(given.transmission, "path.transmission", 1.0);
    if (given.air_temperature_k)
      path = radiometry::absorbing_path(transmission, *given.air_temperature_k);
    else
      path.transmission = transmission;
    path.radiance = curve_of(given.radiance, "path.radiance", kAny);
    return;
  }
  if (given.air_temperature_k || !given.transmission.file.empty() || given.transmission.number != 1.0 ||
      !given.radiance.file.empty() || given.radiance.number != 0.0)
    throw mtf::UsageError(
        "path.table: given together with transmission, radiance or air_temperature; it has both terms");
  loaded.table = std::make_shared<const radiometry::PathTable>(table_of(given, by_pixel));
  if (by_pixel && given.range_m)
    throw mtf::UsageError("path.range: given together with scene.depth_channel; remove one of them");
  if (by_pixel)
    loaded.paths = [table = loaded.table](double, double) { return RangedPaths{table}; };
  else if (given.range_m)
    path = at_key("path.range", [&] { return loaded.table->at(*given.range_m); });
  else
    throw mtf::UsageError("path.range: missing; path.table needs it, or scene.depth_channel");
}

radiometry::SpectralCamera curves_of(const mtf::io::SensorConfig& config, const radiometry::SensorSettings& settings) {
  if (!config.system.band)
    throw mtf::UsageError("band: missing; electrons need it: write [band] wavelength = [\"3.4 um\", \"4.8 um\"]");
  radiometry::SpectralCamera curves;
  curves.band = {config.system.band->lo_um, config.system.band->hi_um};
  if (settings.optics) {
    add_curve(curves.optics, settings.optics->transmission, "optics.transmission");
    add_curve(curves.cold_filter, settings.optics->cold_transmission, "optics.cold_transmission");
  }
  curves.flux = flux_of(settings);
  if (settings.detector)
    add_curve(curves.quantum_efficiency, settings.detector->quantum_efficiency,
              settings.thermal ? "detector.absorptance" : "detector.quantum_efficiency");
  return curves;
}

LoadedSensor load_parts(const mtf::io::SensorConfig& config) {
  LoadedSensor loaded;
  radiometry::Sensor& sensor = loaded.sensor;
  sensor.settings = radiometry::sensor_settings(config.tables);
  const radiometry::SensorSettings& settings = sensor.settings;
  sensor.curves = curves_of(config, settings);
  if (settings.scene) sensor.emissivity = curve_of(settings.scene->emissivity, "scene.emissivity", 1.0);
  if (settings.path && settings.atmosphere)
    throw mtf::UsageError("[atmosphere]: given together with [path]; the air would count twice, so remove one of them");
  if (settings.path)
    read_path(settings, loaded);
  else if (settings.atmosphere)
    read_atmosphere(config.system, settings, loaded);
  else if (settings.scene && !settings.scene->depth_channel.name.empty())
    throw mtf::UsageError(
        "scene.depth_channel: needs [atmosphere] or path.table, which say what a path of that length does");
  if (settings.nonuniformity) {
    sensor.responsivity = map_of(settings.nonuniformity->responsivity, "nonuniformity.responsivity", true);
    sensor.offset = map_of(settings.nonuniformity->offset, "nonuniformity.offset", false);
  }
  loaded.source_k = source_temperature_k(settings, config.scene.quantity);
  if (settings.vignetting)
    sensor.vignetting =
        settings.vignetting->of == radiometry::VignettingOf::wavefront
            ? at_key("vignetting.of",
                     [&] { return std::make_shared<const mtf::Image>(mtf::throughput_image(config.system)); })
            : map_of(settings.vignetting->map, "vignetting.map", true);
  if (settings.detector) require_response(sensor);
  return loaded;
}

/// The message with its place, or with the file at least.
std::string told(const mtf::io::SensorConfig& config, const std::string& message) {
  const std::string text = placed(config, message);
  return text.starts_with(config.file + ":") ? text : config.file + ": " + text;
}

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

/// With counts_per_kelvin nobody has said what a count is in volts. What was measured is in counts x 1 uV, as
/// `mtf characterize` writes it.
std::vector<mtf::io::Diagnostic> invented_volts_warnings(const mtf::io::SensorConfig& config) {
  std::vector<mtf::io::Diagnostic> warnings;
  for (const mtf::TableInfo& table : radiometry::sensor_tables())
    for (const mtf::FieldInfo& row : table.settings) {
      const mtf::SettingsTable* given = find_table(config.tables, table.name);
      const std::string path = std::string(table.name) + "." + std::string(row.name);
      const bool measured = std::any_of(config.fits.begin(), config.fits.end(), [&](const mtf::io::FitSpec& fit) {
        return fit.path == path && (fit.stderr_value || fit.interval);
      });
      if (measured || given == nullptr || row.dimension != mtf::Dimension::voltage) continue;
      const mtf::SettingValue* value = given->find(row.name);
      const double* volts = value != nullptr ? std::get_if<double>(value) : nullptr;
      if (volts == nullptr || *volts == 0.0) continue;
      warnings.push_back(warning_at(path,
                                    "in volts beside detector.counts_per_kelvin, which leaves open how many volts a "
                                    "count is and calls it 1 uV, so that this is taken for " +
                                        mtf::three_digits(1e6 * *volts) +
                                        " counts; give it as counts x 1 uV, or responsivity and adc.volts_per_count "
                                        "in place of counts_per_kelvin"));
    }
  return warnings;
}

/// Curves that stop inside the band. Curves that cannot be are left to load_chain.
std::vector<mtf::io::Diagnostic> curve_warnings(const mtf::io::SensorConfig& config) try {
  if (!has_chain(config) || !config.system.band) return {};
  const radiometry::SensorSettings settings = radiometry::sensor_settings(config.tables);
  const radiometry::SpectralCamera camera = curves_of(config, settings);
  const auto optics = settings.optics.value_or(radiometry::OpticsSettings{});
  // What glows behind a filter reaches the detector where the filter is shut.
  radiometry::Interval open = open_range(camera.band, camera.quantum_efficiency);
  const bool stop_glows = optics.stop_temperature_k > 0.0;
  if (!stop_glows) open = open_range(open, camera.cold_filter);
  if (!stop_glows && optics.temperature_k == 0.0) open = open_range(open, camera.optics);
  const radiometry::Interval seen = open_range(open_range(open, camera.cold_filter), camera.optics);
  std::vector<mtf::io::Diagnostic> warnings;
  const auto check = [&](const char* key, const std::vector<Spectrum>& curves, const radiometry::Interval& all) {
    for (const Spectrum& curve : curves)
      if (std::string text = missing_words(curve, all); !text.empty())
        warnings.push_back(warning_at(key, std::move(text)));
  };
  check("optics.transmission", camera.optics, seen);
  check("optics.cold_transmission", camera.cold_filter, open);
  check(settings.thermal ? "detector.absorptance" : "detector.quantum_efficiency", camera.quantum_efficiency, open);
  if (settings.scene) check("scene.emissivity", {curve_of(settings.scene->emissivity, "scene.emissivity", 1.0)}, seen);
  if (!settings.path) return warnings;
  const radiometry::PathSettings& path = *settings.path;
  if (path.table.empty()) {
    check("path.transmission", {curve_of(path.transmission, "path.transmission", 1.0)}, seen);
    check("path.radiance", {curve_of(path.radiance, "path.radiance", kAny)}, seen);
  } else {
    const radiometry::PathTable table = table_of(path, !path.range_m);
    check("path.table", {table.at(path.range_m.value_or(table.range_m().front())).transmission}, seen);
  }
  return warnings;
} catch (const mtf::Error&) {
  return {};
}

}  // namespace

mtf::io::SensorConfig read_sensor_file(const std::string& file, std::vector<mtf::io::Diagnostic>* diagnostics) {
  mtf::io::SensorConfig config = mtf::io::load_config(file, diagnostics, sensor_schema());
  if (diagnostics != nullptr)
    for (mtf::io::Diagnostic& warning : chain_warnings(config)) diagnostics->push_back(std::move(warning));
  return config;
}

std::vector<std::string> files_of(const mtf::io::SensorConfig& config) {
  std::vector<std::string> files{config.file};
  files.insert(files.end(), config.files.begin(), config.files.end());
  return files;
}

bool has_chain(const mtf::io::SensorConfig& config) { return find_table(config.tables, "detector") != nullptr; }

std::optional<double> source_temperature_k(const radiometry::SensorSettings& settings,
                                           std::optional<mtf::io::Quantity> quantity) {
  using mtf::io::Quantity;
  if (settings.scene && settings.scene->source_temperature_k) return settings.scene->source_temperature_k;
  const bool surfaces = quantity == Quantity::temperature || quantity == Quantity::counts;
  return surfaces ? std::optional(kSurface_k) : std::nullopt;
}

radiometry::SpectralCamera load_curves(const mtf::io::SensorConfig& config) try {
  return curves_of(config, radiometry::sensor_settings(config.tables));
} catch (const mtf::UsageError& error) {
  throw mtf::UsageError(told(config, error.what()));
} catch (const mtf::RuntimeError& error) {
  throw mtf::RuntimeError(told(config, error.what()));
}

LoadedSensor load_chain(const mtf::io::SensorConfig& config) try {
  return load_parts(config);
} catch (const mtf::UsageError& error) {
  throw mtf::UsageError(told(config, error.what()));
} catch (const mtf::RuntimeError& error) {
  throw mtf::RuntimeError(told(config, error.what()));
}

std::shared_ptr<const mtf::ElectronRate> electron_rate(const mtf::System<double>& system, const LoadedSensor& loaded,
                                                       const radiometry::Path& path) {
  const radiometry::SpectralCamera& camera = loaded.sensor.curves;
  const bool even = camera.optics.empty() && camera.cold_filter.empty() && camera.quantum_efficiency.empty() &&
                    path.transmission.value.size() <= 1;
  if (!system.band || (even && !loaded.source_k)) return nullptr;
  const auto chromatic = [&](const auto& entry) { return entry.component.traits(system.context()).chromatic; };
  if (std::none_of(system.stages.begin(), system.stages.end(),
                   [&](const auto& list) { return std::any_of(list.begin(), list.end(), chromatic); }))
    return nullptr;  // nothing is averaged
  const radiometry::SceneBand band = radiometry::scene_band(camera, path);
  const radiometry::BandResponse response(band.band, band.curves);
  const std::string key = response.integral() > 0.0 ? "scene.source_temperature" : "path.transmission";
  return at_key(key, [&] {
    return std::make_shared<const mtf::ElectronRate>(response.electron_rate(loaded.source_k, camera.flux));
  });
}

mtf::System<double> with_electron_rate(const mtf::System<double>& system, const LoadedSensor& loaded) {
  mtf::System<double> weighted = system;
  if (auto rate = electron_rate(system, loaded, loaded.sensor.path)) weighted.band->rate = std::move(rate);
  return weighted;
}

std::string unused_table(const mtf::io::SensorConfig& config) {
  if (has_chain(config)) return "";
  // An OTF that changes over the field needs its axis too.
  const auto unused = std::find_if(config.tables.begin(), config.tables.end(), [&](const mtf::SettingsTable& table) {
    return table.name != "optical_axis" || config.system.is_isoplanatic();
  });
  if (unused == config.tables.end()) return "";
  const mtf::SettingsTable& table = *unused;
  const bool row = table.name == "frame" || table.name == "scene" || table.name == "optics";
  return (row ? std::string(table.name) + "." + std::string(table.settings.front().name)
              : "[" + std::string(table.name) + "]") +
         ": part of the chain to electrons, which begins with [detector]; add that, or remove this";
}

std::optional<mtf::io::Diagnostic> chain_problem(const mtf::io::SensorConfig& config) {
  std::string text = unused_table(config);
  if (has_chain(config)) try {
      const LoadedSensor loaded = load_parts(config);
      require_consistent(config.system, loaded.sensor);
      static_cast<void>(with_electron_rate(config.system, loaded));
    } catch (const mtf::Error& error) {
      text = error.what();
    }
  if (text.empty()) return std::nullopt;
  const mtf::io::Diagnostic whole{.error = true, .position = {}, .path = {}, .text = text};
  return finding_of(config, text).value_or(whole);
}

std::vector<mtf::io::Diagnostic> chain_warnings(const mtf::io::SensorConfig& config) {
  std::vector<mtf::io::Diagnostic> warnings = atmosphere_warnings(config);
  const mtf::SettingsTable* lag = find_table(config.tables, "lag");
  const mtf::SettingValue* given = lag != nullptr ? lag->find("time_constant") : nullptr;
  const auto moving = radiometry::moving_bolometer(config.system);
  const auto add = [&](std::vector<mtf::io::Diagnostic> more) {
    for (mtf::io::Diagnostic& warning : more) warnings.push_back(std::move(warning));
  };
  add(curve_warnings(config));
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
    if (thermal.counts_per_k) add(invented_volts_warnings(config));
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

std::string response_sha256(const radiometry::SpectralCamera& curves) {
  std::string text = curves.flux == radiometry::Flux::watts ? "watts" : "photons";
  const auto add = [&](double number) { text += " " + mtf::significant(number, 17); };
  add(curves.band.lo_um);
  add(curves.band.hi_um);
  for (const auto* list : {&curves.optics, &curves.cold_filter, &curves.quantum_efficiency}) {
    text += "\ncurves";
    for (const radiometry::Spectrum& curve : *list) {
      text += "\ncurve";
      for (std::size_t i = 0; i < curve.value.size(); ++i) {
        add(curve.wavelength_um[i]);
        add(curve.value[i]);
      }
    }
  }
  return mtf::io::sha256_hex(text);
}

}  // namespace apps
