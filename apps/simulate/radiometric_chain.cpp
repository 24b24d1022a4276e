// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/radiometric_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/range_weights.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/components/path_air.h"
#include "mtf/error.h"
#include "mtf/same_list.h"

namespace apps {

namespace {

/// The same tables, and the same numbers of frame, optics and band.
bool same_camera(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b) {
  const auto numbers = [](const mtf::System<double>& system) {
    const auto& [frame, optics, band] = std::tie(system.frame, system.optics, system.band);
    return std::tuple(frame.focal_length_mm, frame.pitch_x_um, frame.pitch_y_um, frame.integration_time_s,
                      optics.f_number, optics.aperture_mm, optics.obscuration, optics.wavelength_um,
                      band ? band->lo_um : 0.0, band ? band->hi_um : 0.0);
  };
  return a.tables == b.tables && numbers(a.system) == numbers(b.system);
}

std::pair<int, int> format_of(const mtf::io::SensorConfig& config) {
  return {config.system.frame.columns, config.system.frame.rows};
}

/// True when load_chain gives the same for both.
bool same_loaded(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b) {
  return same_camera(a, b) && a.scene.quantity == b.scene.quantity && loss_in(a.system) == loss_in(b.system) &&
         takes_path_air(a.system) == takes_path_air(b.system);
}

/// Flat frames go through [[readout]].
bool same_readout(const mtf::System<double>& a, const mtf::System<double>& b) {
  return std::ranges::equal(a.list(mtf::Stage::readout), b.list(mtf::Stage::readout),
                            [](const auto& x, const auto& y) { return mtf::same_component(x.component, y.component); });
}

/// What pixels differ by and are converted by: without light, optics, shading, efficiency and temporal noise.
std::vector<mtf::SettingsTable> tables_of_pixels(const mtf::io::SensorConfig& config) {
  constexpr std::array<std::string_view, 10> kTables{"scene",      "camera_counts", "path",  "atmosphere",    "optics",
                                                     "vignetting", "distortion",    "ghost", "veiling_glare", "agc"};
  constexpr std::array<std::string_view, 8> kKeys{"quantum_efficiency", "dark_current", "read_noise", "reset_noise",
                                                  "other_noise",        "shot",         "row",        "column"};
  std::vector<mtf::SettingsTable> tables = config.tables;
  std::erase_if(tables, [&](const auto& table) { return std::ranges::find(kTables, table.name) != kTables.end(); });
  for (mtf::SettingsTable& table : tables)
    if (table.name == "detector" || table.name == "noise")
      std::erase_if(table.settings, [&](const auto& key) { return std::ranges::find(kKeys, key.name) != kKeys.end(); });
  return tables;
}

FileStates file_states(const mtf::io::SensorConfig& config) {
  const std::vector<std::string> files = files_of(config);
  FileStates states;
  for (std::size_t i = 1; i < files.size(); ++i) {  // the first is the sensor file, whose text is in memory
    std::error_code none;
    const auto time = std::filesystem::last_write_time(files[i], none);
    states.emplace_back(time, std::filesystem::file_size(files[i], none));
  }
  return states;
}

}  // namespace

std::shared_ptr<const RadiometricChain> radiometric_chain_of(const mtf::io::SensorConfig& config,
                                                             std::optional<radiometry::OutputStage> stage) {
  return radiometric_chain_of(config, stage, nullptr, nullptr);
}

std::shared_ptr<const RadiometricChain> radiometric_chain_of(const mtf::io::SensorConfig& config,
                                                             std::optional<radiometry::OutputStage> stage,
                                                             const mtf::io::SensorConfig* before,
                                                             const RadiometricChain* chain) {
  if (!has_chain(config)) {
    if (stage)
      throw mtf::UsageError(config.file +
                            ": --stage is for sensors with [detector]; this one gives the filtered scene only");
    if (const std::string unused = unused_table(config); !unused.empty())
      throw mtf::UsageError(placed(config, config.file + ": " + unused));
    return nullptr;
  }
  auto radiometric = std::make_shared<RadiometricChain>();
  radiometric->files = file_states(config);
  const bool known =
      before != nullptr && chain != nullptr && chain->files == radiometric->files && same_loaded(*before, config);
  radiometric->loaded = known ? chain->loaded : load_chain(config);
  const radiometry::Sensor& sensor = radiometric->loaded.sensor;
  radiometric->system = at_its_place(config, [&] { return with_electron_rate(config.system, radiometric->loaded); });
  const radiometry::OutputStage last = last_output_stage(config.system, sensor);
  radiometric->stage = stage.value_or(last);
  try {
    require_output_stage(radiometric->stage, last, sensor.settings.adc.has_value(),
                         sensor.settings.thermal.has_value());
    require_consistent(config.system, sensor);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(placed(config, config.file + ": " + error.what()));
  }
  return radiometric;
}

double RadiometricChain::tolerance(double otherwise, double std) const {
  return stage < radiometry::OutputStage::dn ? otherwise
                                             : adc_tolerance(system, loaded.sensor, std).value_or(otherwise);
}

double RadiometricChain::unseen_tolerance(double by_default) const {
  const bool counts = stage >= radiometry::OutputStage::dn && loaded.sensor.settings.adc.has_value();
  return counts ? 10.0 / std::sqrt(12.0) * by_default : 0.0;
}

bool remembers(const RadiometricChain& radiometric) {
  const radiometry::SensorSettings& s = radiometric.loaded.sensor.settings;
  return s.lag || s.shutter || (s.thermal && s.thermal->closes());
}

std::string lag_warning(const RadiometricChain& radiometric, std::int64_t steps) {
  const radiometry::SensorSettings& s = radiometric.loaded.sensor.settings;
  if (!s.thermal || !s.lag || !s.frame || !s.frame->frame_time_s || steps == 0) return "";
  const double length_s = static_cast<double>(steps) * *s.frame->frame_time_s;
  if (s.lag->time_constant_s <= length_s) return "";
  return "[lag]: the time constant of " + mtf::three_digits(s.lag->time_constant_s) +
         " s is longer than the sequence of " + mtf::three_digits(length_s) +
         " s, so that its last frame still shows the first one, which is taken for a steady state; give more frames";
}

bool same_light(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b) {
  const auto band = [](const mtf::io::SensorConfig& config) {
    return config.system.band ? std::pair{config.system.band->lo_um, config.system.band->hi_um} : std::pair{0.0, 0.0};
  };
  const auto same = [&](std::string_view name) {
    const auto *first = find_table(a.tables, name), *second = find_table(b.tables, name);
    return first == nullptr || second == nullptr ? first == second : *first == *second;
  };
  return band(a) == band(b) && loss_in(a.system) == loss_in(b.system) && same("scene") && same("camera_counts") &&
         same("path") && same("atmosphere") && same("optics") && same("detector");
}

bool same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b) {
  return same_camera(a, b) && format_of(a) == format_of(b) && same_readout(a.system, b.system);
}

bool nearly_same_correction(const mtf::io::SensorConfig& a, const mtf::io::SensorConfig& b) {
  // The ring of narcissus and the light of a warm shutter are fixed patterns that follow the optics.
  const mtf::SettingsTable* const detector = find_table(a.tables, "detector");
  if (find_table(a.tables, "narcissus") != nullptr || (detector != nullptr && detector->find("shutter_temperature")))
    return false;
  const mtf::Frame<double>&first = a.system.frame, &second = b.system.frame;
  return first.pitch_x_um == second.pitch_x_um && first.pitch_y_um == second.pitch_y_um &&
         format_of(a) == format_of(b) && same_readout(a.system, b.system) && tables_of_pixels(a) == tables_of_pixels(b);
}

SceneLight to_light(const mtf::io::SensorConfig& config, const RadiometricChain& radiometric, mtf::io::Scene& scene,
                    std::vector<mtf::Image>& masks, const SceneSource& source, int threads) {
  mtf::Image bad;
  for (mtf::Image& mask : masks) {
    if (mask.size() == 0) continue;
    if (bad.size() == 0)
      bad = std::move(mask);
    else
      for (std::int64_t i = 0; i < bad.size(); ++i) bad.data()[i] = std::max(bad.data()[i], mask.data()[i]);
  }
  masks.clear();
  masks.push_back(std::move(bad));
  const SceneLight light = at_its_place(config, [&] {
    SceneLight made = to_light(config, radiometric.loaded, scene, source, threads);
    if (made.ranges) {
      RangeWeights weights = range_weights(radiometric.system, radiometric.loaded, *made.ranges);
      made.rate = std::move(weights.rate);
      if (!weights.warning.empty()) made.warnings.push_back(std::move(weights.warning));
    }
    return made;
  });
  // The scene's own values are finite here: bad pixels have been filled or refused.
  if (!mtf::all_finite(scene.planes.front().view())) refuse_overflow(scene.names.front());
  return light;
}

ChainReport report_of(const RadiometricChain& radiometric) {
  ChainReport report;
  report.stage = radiometry::output_stage_name(radiometric.stage);
  report.quantity = radiometric.quantity();
  report.unit = radiometric.unit();
  report.stages = chain_stages(radiometric.system, radiometric.loaded.sensor);
  report.held.volts = radiometric.loaded.sensor.settings.thermal.has_value();
  return report;
}

void add_chain(mtf::io::Metadata& metadata, const RadiometricChain& radiometric, std::uint32_t frame) {
  metadata.text["mtf:quantity"] = radiometric.quantity();
  metadata.text["mtf:units"] = radiometric.unit();
  metadata.text["mtf:tap"] = radiometry::output_stage_name(radiometric.stage);
  const auto& noise = radiometric.loaded.sensor.settings.noise;
  if (noise) metadata.text["mtf:noise"] = "seed " + std::to_string(noise->seed) + ", frame " + std::to_string(frame);
  metadata.history.back() = "mtf simulate: chain to " + metadata.text["mtf:tap"];
}

IntegerRange integer_range(const RadiometricChain* radiometric, const SimulateOptions& options) {
  IntegerRange range{.ends = options.range};
  if (radiometric == nullptr) return range;
  const radiometry::SensorSettings& settings = radiometric->loaded.sensor.settings;
  const bool levels = radiometric->unit() == "levels";
  if (levels && settings.agc->most_level <= 255.0) range.bits = 8;
  if (range.ends) return range;
  if (levels) range.ends = std::array{0.0, settings.agc->most_level};
  if (radiometric->unit() == "counts" && settings.adc && settings.adc->bits <= 16)
    range.ends = std::array{0.0, 65535.0};
  return range;
}

mtf::Image cropped(const mtf::Image& image, const std::array<std::int64_t, 4>& region) {
  const auto& [x, y, width, height] = region;
  if (x < 0 || y < 0 || width < 1 || height < 1 || x + width > image.width() || y + height > image.height())
    throw mtf::UsageError("--roi: " + std::to_string(width) + "x" + std::to_string(height) + " pixels from (" +
                          std::to_string(x) + ", " + std::to_string(y) + ") are not all inside the image of " +
                          std::to_string(image.width()) + "x" + std::to_string(image.height()));
  mtf::Image part(width, height);
  for (std::int64_t row = 0; row < height; ++row)
    std::copy_n(image.data() + (y + row) * image.width() + x, width, part.data() + row * width);
  return part;
}

}  // namespace apps
