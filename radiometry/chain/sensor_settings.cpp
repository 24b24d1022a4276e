// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/sensor_settings.h"

#include <algorithm>

namespace radiometry {
namespace {

constexpr mtf::GivenWord kThermal{"detector", "kind", "thermal"};

/// The table of a thermal detector: volts in place of electrons.
mtf::TableInfo in_volts(mtf::TableInfo table) {
  using mtf::Dimension;
  table.where = kThermal;
  for (FieldInfo& info : table.settings) {
    if (info.dimension != Dimension::electrons) continue;
    info.dimension = Dimension::voltage;
    info.unit = "V";
    info.example = "\"2 mV\"";
    if (info.name == "electrons_per_count") {
      info.name = "volts_per_count";
      info.example = "\"50 uV\"";
      info.doc = "volts of one count; not with counts_per_kelvin of [detector]";
      table.absent.push_back(
          {"electrons_per_count", "the signal of a thermal detector is in volts; write volts_per_count"});
    }
  }
  return table;
}

void drop_row(mtf::TableInfo& table, std::string_view name) {
  std::erase_if(table.settings, [&](const FieldInfo& row) { return row.name == name; });
}

/// Flat frames of a thermal detector are those of two blackbodies.
void set_blackbodies(mtf::TableInfo& table) {
  const auto blackbody = [](std::string_view name, std::string_view example, std::string_view doc) {
    return optional_row(name, "K", 1.0, kMostTemperature_k, example, doc);
  };
  for (const auto& [key, row] :
       {std::pair{"low", blackbody("cold", "\"10 degC\"", "of the blackbody that the cold flat frame shows")},
        std::pair{"high", blackbody("hot", "\"40 degC\"", "of the blackbody that the hot flat frame shows")}}) {
    drop_row(table, key);
    table.settings.push_back(row);
  }
  table.absent = {{"low", "a part of the full well, which a thermal detector does not have; write cold = \"10 degC\""},
                  {"high", "a part of the full well, which a thermal detector does not have; write hot = \"40 degC\""}};
}

mtf::TableInfo thermal_detector_table() {
  mtf::TableInfo table = table_info<ThermalSettings>("detector", "from watts to volts, of a thermal detector");
  table.where = kThermal;
  table.absent = {
      {"quantum_efficiency", "a thermal detector absorbs power; write absorptance"},
      {"full_well", "a thermal detector has no well; the range is that of [adc]: give its volts_per_count and bits"},
      {"dark_current", "a thermal detector has none; give the noise as netd, nep, dstar or by its physics"},
      {"read_noise", "of a thermal detector it is a voltage; write readout_noise"},
      {"reset_noise", "a thermal detector has none; what the readout adds is readout_noise"},
      {"other_noise",
       "a thermal detector gives its noise as netd, nep, dstar or by its physics; what the readout adds is "
       "readout_noise"},
      {"capacitance", "a thermal detector resets none; its heat_capacity is in J/K"}};
  return table;
}

/// The tables that differ for a thermal detector.
std::vector<mtf::TableInfo> thermal_tables(const std::vector<mtf::TableInfo>& photon) {
  std::vector<mtf::TableInfo> tables{thermal_detector_table()};
  for (const mtf::TableInfo& table : photon) {
    const bool electrons = std::any_of(table.settings.begin(), table.settings.end(),
                                       [](const FieldInfo& row) { return row.dimension == mtf::Dimension::electrons; });
    if (table.name == "detector" || !(electrons || table.name == "lag" || table.name == "correction")) continue;
    tables.push_back(in_volts(table));
    mtf::TableInfo& added = tables.back();
    const auto drop = [&](std::string_view name, std::string_view why) {
      drop_row(added, name);
      added.absent.push_back({name, why});
    };
    if (table.name == "noise") drop("shot", "a thermal detector counts no photons and has no shot noise; remove it");
    if (table.name == "nonuniformity") drop("dcnu", "a thermal detector has no dark current; remove it");
    if (table.name == "correction") set_blackbodies(added);
    if (table.name == "lag")
      added.settings.front().presence = mtf::Presence::optional;  // or heat_capacity / conductance
  }
  return tables;
}

/// A pixel has one time constant: that of its heat capacity and conductance, or the one of [lag].
void set_time_constant(Lag& lag, const ThermalSettings& thermal, bool given) {
  const bool own = thermal.heat_capacity_j_k && thermal.conductance_w_k;
  if (own && given)
    throw mtf::UsageError("lag.time_constant: given beside detector.heat_capacity and conductance, which are " +
                          mtf::format_double(*thermal.heat_capacity_j_k / *thermal.conductance_w_k) +
                          " s; remove it here, [lag] takes theirs");
  if (!own && !given)
    throw mtf::UsageError("[lag]: time_constant is missing; write for example time_constant = \"10 ms\"");
  if (own) lag.time_constant_s = *thermal.heat_capacity_j_k / *thermal.conductance_w_k;
}

/// Counts for a kelvin say how many counts a kelvin gives, not how many volts: a count is 1 uV then.
void set_counts_per_kelvin(SensorSettings& settings) {
  constexpr double kVoltsOfACount = 1e-6;
  if (!settings.thermal->counts_per_k) {
    if (settings.adc && !settings.adc->electrons_per_count)
      throw mtf::UsageError("adc.volts_per_count: missing; write for example volts_per_count = \"50 uV\"");
    return;
  }
  if (!settings.adc)
    throw mtf::UsageError(
        "detector.counts_per_kelvin: there are no counts without [adc]; add it, or give responsivity");
  if (settings.adc->electrons_per_count)
    throw mtf::UsageError(
        "detector.counts_per_kelvin: given beside adc.volts_per_count; it stands for responsivity and volts_per_count "
        "together: remove it or that");
  settings.adc->electrons_per_count = kVoltsOfACount;
}

/// A frame rate as a noise bandwidth: frames of time t that integrate all of it have 1/(2 t), half the rate.
void set_frame_rates(SensorSettings& settings) {
  ThermalSettings& thermal = *settings.thermal;
  if (!thermal.netd_frame_rate_hz) return;
  for (const auto& [key, given] : {std::pair{"netd_bandwidth", thermal.netd_bandwidth_hz.has_value()},
                                   std::pair{"noise_bandwidth", thermal.bandwidth_hz.has_value()}})
    if (given)
      throw mtf::UsageError(std::string("detector.netd_frame_rate: given beside ") + key +
                            "; frame rates take the place of both bandwidths: remove it or that");
  if (!settings.frame || !settings.frame->frame_time_s)
    throw mtf::UsageError(
        "frame.frame_time: missing; detector.netd_frame_rate is compared with the rate of this camera: for example "
        "\"20 ms\"");
  thermal.netd_bandwidth_hz = 0.5 * *thermal.netd_frame_rate_hz;
  thermal.bandwidth_hz = 0.5 / *settings.frame->frame_time_s;
}

}  // namespace

DetectorSettings pixel_settings(const ThermalSettings& thermal, bool square) {
  DetectorSettings pixel;
  pixel.square = square;
  pixel.kind = DetectorKind::thermal;
  pixel.width_um = thermal.width_um;
  pixel.height_um = thermal.height_um;
  pixel.quantum_efficiency = thermal.absorptance;
  return pixel;
}

CameraEmission emission_of(const SensorSettings& settings) {
  const OpticsSettings optics = settings.optics.value_or(OpticsSettings{});
  const ThermalSettings thermal = settings.thermal.value_or(ThermalSettings{});
  return {optics.temperature_k, optics.stop_temperature_k, optics.stop_band, thermal.shutter_k.value_or(0.0),
          thermal.shutter_place};
}

ShutterEvents shutter_events(const SensorSettings& settings) {
  const ThermalSettings& thermal = *settings.thermal;
  const double frame_time_s = *settings.frame->frame_time_s;
  return {.drift_k_s = thermal.drift_k_s,
          .frame_time_s = frame_time_s,
          .interval = thermal.shutter_interval_s ? interval_frames(*thermal.shutter_interval_s, frame_time_s)
                                                 : static_cast<std::uint32_t>(thermal.shutter_frames)};
}

std::vector<mtf::TableInfo> sensor_tables() {
  std::vector<mtf::TableInfo> tables;
  for_each_table([&]<class T>(const SensorTable<T>& row) { tables.push_back(table_info<T>(row.name, row.doc)); });
  for (mtf::TableInfo& table : thermal_tables(tables)) tables.push_back(std::move(table));
  return tables;
}

SensorSettings sensor_settings(const std::vector<mtf::SettingsTable>& tables) {
  SensorSettings settings;
  for_each_table([&]<class T>(const SensorTable<T>& row) {
    if (const mtf::SettingsTable* table = find_table(tables, row.name)) settings.*row.values = from_table<T>(*table);
  });
  if (!settings.detector) return settings;
  const mtf::SettingsTable& detector = *find_table(tables, "detector");
  settings.detector->square = width_is_square(detector);
  if (settings.detector->square && detector.find("height") != nullptr && detector.find("width") == nullptr)
    throw mtf::UsageError("detector.height: given without width; give both, or width alone for a square");
  if (settings.detector->kind != DetectorKind::thermal) return settings;
  settings.thermal = from_table<ThermalSettings>(detector);
  settings.detector = pixel_settings(*settings.thermal, settings.detector->square);
  if (settings.lag)
    set_time_constant(*settings.lag, *settings.thermal, find_table(tables, "lag")->find("time_constant") != nullptr);
  const auto number = [&](std::string_view table, std::string_view key) -> std::optional<double> {
    const mtf::SettingValue* value = find_table(tables, table)->find(key);
    return value != nullptr ? std::optional(std::get<double>(*value)) : std::nullopt;
  };
  if (settings.correction) {
    settings.correction->low = 0.0, settings.correction->high = 1.0;
    settings.correction->cold_k = number("correction", "cold");
    settings.correction->hot_k = number("correction", "hot");
  }
  if (settings.adc) settings.adc->electrons_per_count = number("adc", "volts_per_count");
  set_counts_per_kelvin(settings);
  set_frame_rates(settings);
  return settings;
}

}  // namespace radiometry
