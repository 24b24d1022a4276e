// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/sensor_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/scene_light.h"
#include "apps/text/message_words.h"
#include "mtf/components/path_air.h"
#include "mtf/error.h"
#include "mtf/otf/same_list.h"

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

std::string unit_of(const RadiometricChain& chain) {
  return std::string(output_unit(chain.loaded.sensor, chain.stage));
}

/// The masks of bad pixels as one.
std::vector<mtf::Image> merged(std::vector<mtf::Image> masks) {
  std::vector<mtf::Image> one(1);
  mtf::Image& bad = one.front();
  for (mtf::Image& mask : masks) {
    if (mask.size() == 0) continue;
    if (bad.size() == 0)
      bad = std::move(mask);
    else
      for (std::int64_t i = 0; i < bad.size(); ++i) bad.data()[i] = std::max(bad.data()[i], mask.data()[i]);
  }
  return one;
}

}  // namespace

SensorRun::SensorRun(std::shared_ptr<const mtf::io::SensorConfig> shared, std::optional<radiometry::OutputStage> stage,
                     const SensorRun* before)
    : config_(std::move(shared)) {
  const mtf::io::SensorConfig& config = *config_;
  if (!has_chain(config)) {
    if (stage)
      throw mtf::UsageError(config.file +
                            ": --stage is for sensors with [detector]; this one gives the filtered scene only");
    if (const std::string unused = unused_table(config); !unused.empty())
      throw mtf::UsageError(placed(config, config.file + ": " + unused));
    return;
  }
  auto made = std::make_shared<RadiometricChain>();
  made->files = file_states(config);
  const bool known = before != nullptr && before->chain_ && before->chain_->files == made->files &&
                     same_loaded(*before->config_, config);
  made->loaded = known ? before->chain_->loaded : load_chain(config);
  const radiometry::Sensor& sensor = made->loaded.sensor;
  made->system = at_its_place(config, [&] { return with_electron_rate(config.system, made->loaded); });
  const radiometry::OutputStage last = last_output_stage(config.system, sensor);
  made->stage = stage.value_or(last);
  try {
    require_output_stage(made->stage, last, sensor.settings.adc.has_value(), sensor.settings.thermal.has_value());
    require_consistent(config.system, sensor);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(placed(config, config.file + ": " + error.what()));
  }
  chain_ = std::move(made);
}

SceneLight SensorRun::light(mtf::io::Scene& scene, std::vector<mtf::Image>& masks, const SceneSource& source,
                            int threads) const {
  if (!chain_) return {.border_value = config_->scene.border_value};
  masks = merged(std::move(masks));
  SceneLight light = at_its_place(*config_, [&] {
    SceneLight made = to_light(*config_, chain_->loaded, scene, source, threads);
    if (made.ranges) {
      RangeWeights weights = range_weights(chain_->system, chain_->loaded, *made.ranges);
      made.rate = std::move(weights.rate);
      if (!weights.warning.empty()) made.warnings.push_back(std::move(weights.warning));
    }
    return made;
  });
  // The scene's own values are finite here: bad pixels have been filled or refused.
  if (!mtf::all_finite(scene.planes.front().view())) refuse_overflow(scene.names.front());
  return light;
}

double SensorRun::tolerance(const std::optional<double>& asked, std::optional<double> std) const {
  const double by_default = mtf::PlanOptions().tolerance;
  if (asked || !chain_ || !std || chain_->stage < radiometry::OutputStage::dn) return asked.value_or(by_default);
  return adc_tolerance(chain_->system, chain_->loaded.sensor, *std).value_or(by_default);
}

double SensorRun::unseen_tolerance(double by_default) const {
  const bool counts =
      chain_ && chain_->stage >= radiometry::OutputStage::dn && chain_->loaded.sensor.settings.adc.has_value();
  return counts ? 10.0 / std::sqrt(12.0) * by_default : 0.0;
}

bool SensorRun::remembers() const {
  if (!chain_) return false;
  const radiometry::SensorSettings& s = chain_->loaded.sensor.settings;
  return s.lag || s.shutter || (s.thermal && s.thermal->closes());
}

std::string SensorRun::lag_warning(std::int64_t steps) const {
  if (!chain_) return "";
  const radiometry::SensorSettings& s = chain_->loaded.sensor.settings;
  if (!s.thermal || !s.lag || !s.frame || !s.frame->frame_time_s || steps == 0) return "";
  const double length_s = static_cast<double>(steps) * *s.frame->frame_time_s;
  if (s.lag->time_constant_s <= length_s) return "";
  return "[lag]: the time constant of " + mtf::three_digits(s.lag->time_constant_s) +
         " s is longer than the sequence of " + mtf::three_digits(length_s) +
         " s, so that its last frame still shows the first one, which is taken for a steady state; give more frames";
}

std::optional<ChainReport> SensorRun::report() const {
  if (!chain_) return std::nullopt;
  const radiometry::Sensor& sensor = chain_->loaded.sensor;
  ChainReport report;
  report.stage = radiometry::output_stage_name(chain_->stage);
  report.quantity = output_quantity(sensor, chain_->stage);
  report.unit = unit_of(*chain_);
  report.stages = chain_stages(chain_->system, sensor);
  report.held.volts = sensor.settings.thermal.has_value();
  return report;
}

mtf::io::Metadata SensorRun::metadata(const mtf::io::Scene& scene, const mtf::SensorPlan& plan, double tolerance,
                                      std::int64_t frame,
                                      const std::optional<std::array<std::int64_t, 4>>& region) const {
  mtf::io::Metadata metadata = provenance(*config_, scene, plan, tolerance, region);
  if (!chain_) return metadata;
  metadata.lists.erase("mtf:wavelength");
  metadata.text["mtf:quantity"] = output_quantity(chain_->loaded.sensor, chain_->stage);
  metadata.text["mtf:units"] = unit_of(*chain_);
  metadata.text["mtf:tap"] = radiometry::output_stage_name(chain_->stage);
  const auto& settings = chain_->loaded.sensor.settings;
  if (settings.path || settings.atmosphere) metadata.text["mtf:path"] = "included";
  if (const auto& noise = settings.noise; noise)
    metadata.text["mtf:noise"] = "seed " + std::to_string(noise->seed) + ", frame " + std::to_string(frame);
  metadata.history.back() = "mtf simulate: chain to " + metadata.text["mtf:tap"];
  return metadata;
}

IntegerRange SensorRun::integer_range(const std::optional<std::array<double, 2>>& asked) const {
  IntegerRange range{.ends = asked};
  if (!chain_) return range;
  const radiometry::SensorSettings& settings = chain_->loaded.sensor.settings;
  const bool levels = unit_of(*chain_) == "levels", counts = unit_of(*chain_) == "counts";
  if (levels && settings.agc->most_level <= 255.0) range.bits = 8;
  if (range.ends) return range;
  if (levels) range.ends = std::array{0.0, settings.agc->most_level};
  if (counts && settings.adc && settings.adc->bits <= 16) range.ends = std::array{0.0, 65535.0};
  return range;
}

bool same_light(const SensorRun& one, const SensorRun& other) {
  if (one.is_linear() || other.is_linear()) return one.is_linear() == other.is_linear();
  const mtf::io::SensorConfig &a = one.config(), &b = other.config();
  // The weights of the band at the ranges of the pixels are those of the presample OTF.
  if (other.chain()->loaded.paths && !mtf::same_list(a.system, b.system, mtf::Stage::presample)) return false;
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
  // The ring of narcissus and the light of a warm shutter are fixed patterns that follow the optics, unequal dark
  // current is one that follows the exposure.
  const mtf::SettingsTable *const detector = find_table(a.tables, "detector"), *const unequal = find_table(
                                                                                   a.tables, "nonuniformity");
  if (find_table(a.tables, "narcissus") != nullptr || (detector != nullptr && detector->find("shutter_temperature")) ||
      (unequal != nullptr && unequal->find("dcnu")))
    return false;
  const mtf::Frame<double>&first = a.system.frame, &second = b.system.frame;
  return first.pitch_x_um == second.pitch_x_um && first.pitch_y_um == second.pitch_y_um &&
         format_of(a) == format_of(b) && same_readout(a.system, b.system) && tables_of_pixels(a) == tables_of_pixels(b);
}

void require_one_drift(const mtf::io::SensorConfig& sensor, const mtf::io::Schedule& schedule) {
  constexpr std::array<std::string_view, 3> kDrifting{"detector.shutter_temperature", "optics.stop_temperature",
                                                      "optics.temperature"};
  const auto settings = radiometry::sensor_settings(sensor.tables);
  if (!settings.thermal) return;
  const auto& lines = schedule.settings;
  const bool drifts = settings.thermal->drift_k_s != 0.0 ||
                      std::any_of(lines.begin(), lines.end(),
                                  [](const auto& line) { return line.parameter == "detector.shutter_drift"; });
  if (!drifts) return;
  for (const mtf::io::Setting& line : lines)
    if (line.frame > 0 && std::find(kDrifting.begin(), kDrifting.end(), line.parameter) != kDrifting.end())
      throw mtf::UsageError(schedule.file + ":" + std::to_string(line.line) + ": error: " + line.parameter +
                            ": the temperature at frame " + std::to_string(line.frame) +
                            ", which detector.shutter_drift states too: it warms shutter, housing and optics from "
                            "frame 0 on; remove shutter_drift, or the lines of temperatures after frame 0");
}

void refuse_overflow(const std::string& channel) {
  throw mtf::RuntimeError("channel " + one_line(channel) +
                          ": filtered values exceed what float32 holds (3.4e38); scale the scene with scene.gain");
}

mtf::Image cropped(const mtf::Image& image, const std::array<std::int64_t, 4>& region) {
  const auto& [x, y, width, height] = region;
  if (x < 0 || y < 0 || width < 1 || height < 1 || x + width > image.width() || y + height > image.height())
    throw mtf::UsageError("--roi: " + std::to_string(width) + "x" + std::to_string(height) + " pixels from (" +
                          std::to_string(x) + ", " + std::to_string(y) + ") are not all inside the image of " +
                          std::to_string(image.width()) + "x" + std::to_string(image.height()));
  return copy_of(part_of(image.view(), {x, y, width, height}));
}

}  // namespace apps
