// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/blackbodies.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/budget_table.h"
#include "apps/edges/fit_parameters.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_place.h"
#include "apps/text/message_words.h"
#include "calib/characterize/thermal.h"
#include "mtf/io/config/replace_value.h"
#include "radiometry/chain/chain.h"

namespace apps {
namespace {

using calib::Finding, calib::Verdict;
using radiometry::scene_derivative, radiometry::scene_radiance;

/// What a stack sees: the surface of a blackbody.
radiometry::Surface surface_of(const Blackbodies& bodies, double temperature_k) {
  return {temperature_k, radiometry::constant_spectrum("emissivity", bodies.emissivity), bodies.surroundings_k};
}

radiometry::Surface perfect(double temperature_k) { return {.temperature_k = temperature_k}; }

/// Keys of the nominal in whose place measured ones stand: other forms of the noise and of the signal, and noise that
/// would count twice.
constexpr std::array<std::string_view, 34> kReplaced{"detector.responsivity",
                                                     "adc.volts_per_count",
                                                     "detector.readout_noise",
                                                     "detector.nep",
                                                     "detector.nep_bandwidth",
                                                     "detector.nep_density",
                                                     "detector.dstar",
                                                     "detector.heat_capacity",
                                                     "detector.conductance",
                                                     "detector.temperature",
                                                     "detector.resistance",
                                                     "detector.tcr",
                                                     "detector.bias",
                                                     "detector.corner",
                                                     "detector.lowest_frequency",
                                                     "detector.netd_bandwidth",
                                                     "detector.netd_shortest",
                                                     "detector.netd_longest",
                                                     "detector.netd_frame_rate",
                                                     "nonuniformity.prnu",
                                                     "nonuniformity.prnu_row",
                                                     "nonuniformity.prnu_column",
                                                     "nonuniformity.dsnu",
                                                     "nonuniformity.responsivity",
                                                     "nonuniformity.offset",
                                                     "noise.row",
                                                     "noise.column",
                                                     "noise.fixed_row",
                                                     "noise.fixed_column",
                                                     "noise_3d.vh",
                                                     "noise_3d.tvh",
                                                     "detector.netd",
                                                     "detector.counts_per_kelvin",
                                                     "adc.rounding"};

struct NoiseKey {
  std::string_view finding, key;
};
constexpr std::array kNoiseKeys{NoiseKey{"noise_t", "noise_3d.t"},   NoiseKey{"noise_v", "noise_3d.v"},
                                NoiseKey{"noise_h", "noise_3d.h"},   NoiseKey{"noise_tv", "noise_3d.tv"},
                                NoiseKey{"noise_th", "noise_3d.th"}, NoiseKey{"dsnu", "nonuniformity.dsnu"}};

/// The transmission at which a lens of the camera's f-number alone lets a kelvin through as the whole camera does.
double reference_transmission(const mtf::System<double>& system, const radiometry::Sensor& sensor, double reference_k) {
  const radiometry::Camera<double> camera = camera_of(system, sensor);
  radiometry::SpectralCamera bare = sensor.curves;
  bare.optics.clear();
  bare.cold_filter.clear();
  return camera.transmission * camera.cold_transmission * (1.0 - camera.obscuration * camera.obscuration) *
         scene_derivative(sensor.curves, perfect(reference_k), {}) / scene_derivative(bare, perfect(reference_k), {});
}

void add_predictions(calib::Characterization& camera, const mtf::io::SensorConfig& twin) {
  const BudgetTable budget = budget_table(twin, load_chain(twin), camera.reference_k);
  for (const radiometry::BudgetRow& row : budget.rows)
    if (row.name == "mrtd" || row.name == "mdtd")
      camera.findings.push_back({.name = row.name,
                                 .unit = "mK",
                                 .verdict = row.refused.empty() ? Verdict::predicted : Verdict::not_determined,
                                 .value = row.value,
                                 .from = "predicted, " + row.doc + "; more: mtf budget --curves",
                                 .why = row.refused});
}

}  // namespace

bool is_thermal(const mtf::io::SensorConfig& nominal) {
  const mtf::SettingsTable* detector = find_table(nominal.tables, "detector");
  return detector != nullptr &&
         radiometry::from_table<radiometry::DetectorSettings>(*detector).kind == radiometry::DetectorKind::thermal;
}

calib::Characterization characterize_blackbodies(std::vector<calib::Stack> stacks, const StacksFile& file,
                                                 const mtf::io::SensorConfig& nominal) {
  const mtf::io::SensorConfig clear = without_path(nominal);
  const radiometry::Sensor sensor = load_chain(clear).sensor;
  const Blackbodies& bodies = file.blackbodies;
  const radiometry::Interval& band = sensor.curves.band;
  double coolest_k = mtf::kInfinity, hottest_k = 0.0;
  for (calib::Stack& stack : stacks) {
    const double temperature_k =
        file.unit == LightUnit::temperature
            ? stack.light
            : radiometry::band_temperature(radiometry::Flux::watts, band.lo_um, band.hi_um, stack.light);
    const radiometry::Surface surface = surface_of(bodies, temperature_k);
    stack.light = scene_radiance(sensor.curves, surface, {});
    stack.light_per_k = scene_derivative(sensor.curves, surface, {});
    stack.light_per_emissivity = scene_radiance(sensor.curves, perfect(temperature_k), {}) -
                                 scene_radiance(sensor.curves, perfect(bodies.surroundings_k), {});
    coolest_k = std::min(coolest_k, temperature_k);
    hottest_k = std::max(hottest_k, temperature_k);
  }
  const auto& thermal = sensor.settings.thermal;
  const bool stated = thermal && thermal->netd_temperature_k;
  const double reference_k = bodies.reference_k.value_or(stated ? *thermal->netd_temperature_k : coolest_k);
  const radiometry::Budget<double> budget =
      at_its_place(clear, [&] { return budget_of(clear.system, sensor, reference_k); });
  const double gain = electrons_per_radiance(camera_of(clear.system, sensor), pixel_of(clear.system, sensor));
  calib::Characterization camera = calib::characterize_thermal(
      std::move(stacks), {.reference_k = reference_k,
                          .radiance = scene_radiance(sensor.curves, perfect(reference_k), {}),
                          .radiance_per_k = scene_derivative(sensor.curves, perfect(reference_k), {}),
                          .own_radiance = (budget.signal.total_e() - budget.signal.scene_e) / gain,
                          .temperature_sd_k = bodies.temperature_sd_k,
                          .emissivity_sd = bodies.emissivity_sd});
  camera.findings.front().from += bodies.reference_k ? " (reference_temperature)"
                                  : stated           ? " (netd_temperature of the nominal)"
                                                     : " (the coolest blackbody)";
  if (std::abs(2.0 * reference_k - coolest_k - hottest_k) > 3.0 * (hottest_k - coolest_k))
    camera.warnings.push_back("kelvin are those at " + significant(reference_k, 6) + " K, far from the blackbodies (" +
                              significant(coolest_k, 6) + " to " + significant(hottest_k, 6) +
                              " K); set reference_temperature in [options]");
  return camera;
}

CameraFile thermal_camera_file(calib::Characterization& camera, const StacksFile& stacks, mtf::io::SensorConfig nominal,
                               int bits, const std::string& destination) {
  CameraFile file;
  if (!is_thermal(nominal)) {
    file.left_out.emplace_back("a sensor file: gain and read noise of a photon detector take stacks by photons");
    return file;
  }
  const auto set = [&](const std::string& key, const std::string& value) {
    nominal = mtf::io::replaced(nominal, key, value);
  };
  const auto text = [](double value, const std::string& unit) {
    return mtf::format_double(rounded_to_error(value, 0.0)) + unit;
  };
  const mtf::io::SensorConfig clear = without_path(nominal);
  const radiometry::Sensor sensor = load_chain(clear).sensor;
  const radiometry::ThermalSettings& thermal = *sensor.settings.thermal;
  const auto& frame = sensor.settings.frame;
  if (sensor.settings.lag && thermal.heat_capacity_j_k && thermal.conductance_w_k)
    set("lag.time_constant", text(*thermal.heat_capacity_j_k / *thermal.conductance_w_k, " s"));
  for (const std::string_view key : kReplaced) nominal = without_key(std::move(nominal), std::string(key));
  set("adc.bits", std::to_string(bits));
  set("adc.offset", value_with_error(*camera.find("offset"), ""));
  set("detector.counts_per_kelvin", value_with_error(*camera.find("sitf"), ""));
  set("detector.netd", value_with_error(*camera.find("netd"), " mK"));
  set("detector.netd_of", "camera");
  set("detector.netd_temperature", text(camera.reference_k, " K"));
  set("detector.netd_f_number", text(camera_of(clear.system, sensor).f_number, ""));
  set("detector.netd_transmission", text(reference_transmission(clear.system, sensor, camera.reference_k), ""));
  if (!thermal.bandwidth_hz && frame && frame->frame_time_s)
    set("detector.netd_frame_rate", text(1.0 / *frame->frame_time_s, " Hz"));
  const double uv_per_mk = 1e-3 * camera.find("sitf")->value;  // a count is called 1 uV where counts_per_kelvin stands
  for (const NoiseKey& one : kNoiseKeys)
    set(std::string(one.key), value_with_error(*camera.find(one.finding), " uV", uv_per_mk));
  set("nonuniformity.prnu", value_with_error(*camera.find("prnu"), ""));
  nominal = with_pixels(std::move(nominal), camera, " uV", uv_per_mk);
  nominal = with_lag(std::move(nominal), camera);
  add_not_measured(file, {"optics.transmission", "detector.absorptance", "optics.f_number", "band.wavelength"},
                   nominal);
  add_predictions(camera, without_path(nominal));
  file.text = file_head(camera, stacks, file) + own_named(nominal, destination).text;
  return file;
}

std::vector<Figure> predicted_figures(const calib::Characterization& camera, const std::string& twin,
                                      const std::string& destination) {
  const Finding* const mrtd = camera.find("mrtd");
  if (mrtd == nullptr || mrtd->verdict != calib::Verdict::predicted) return {};
  const mtf::io::ConfigResult read = mtf::io::parse_config(twin, destination, sensor_schema());
  return minimum_temperature_figures(without_path(read.config), camera.reference_k);
}

}  // namespace apps
