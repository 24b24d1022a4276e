// SPDX-License-Identifier: Apache-2.0

// The budget of a sensor file, from the same numbers as its chain.

#include <algorithm>
#include <cmath>

#include "mtf/engines/statistics.h"
#include "radiometry/chain/sensor_budget.h"
#include "radiometry/light/scene_radiance.h"
#include "radiometry/stages/noise/frame_flicker.h"

namespace radiometry {
namespace {

constexpr std::string_view kAtmospherePrefix = "atmosphere.";

/// A curve in whose place a number is given.
void set_constant(Spectrum& spectrum, std::string_view name, const Overrides<double>& numbers, double most) {
  if (const double* value = numbers.find(name)) spectrum = constant_spectrum(std::string(name), *value, most);
}

/// Of a blackbody before the camera; 0 where there is none.
double flat_radiance(const Sensor& sensor, std::optional<double> CorrectionSettings::*temperature_k) {
  const auto& correction = sensor.settings.correction;
  if (!correction || !((*correction).*temperature_k)) return 0.0;
  return scene_radiance(sensor.curves, {.temperature_k = *((*correction).*temperature_k)}, {});
}

Surface surface_of(const Sensor& sensor, double temperature_k, const Overrides<double>& numbers) {
  const auto& scene = sensor.settings.scene;
  const double given = scene ? scene->surroundings_k.value_or(0.0) : 0.0;
  Surface surface{temperature_k, sensor.emissivity, numbers("scene.surroundings", given)};
  set_constant(surface.emissivity, "scene.emissivity", numbers, 1.0);
  return surface;
}

/// True where the mean of a map is the expected one: within 1e-3 of `scale`, or within the sampling error that the mean
/// of so many independent pixels has.
bool has_mean(const mtf::Image& map, const mtf::Statistics& measured, double expected, double scale) {
  constexpr double kSigmas = 4.0;
  const double sampling = kSigmas * measured.std / std::sqrt(static_cast<double>(map.size()));
  return std::abs(measured.mean - expected) <= std::max(1e-3 * scale, sampling);
}

/// Part of the pixels whose dark charge, log-normal (fixed_pattern.h), takes the mean signal beyond the full well.
double filled_by_dark(const Sensor& sensor, const Budget<double>& budget) {
  const auto& unequal = sensor.settings.nonuniformity;
  const double dark_e = budget.signal.dark_e;
  if (!unequal || !(unequal->dcnu > 0.0) || !(dark_e > 0.0)) return 0.0;
  const double room_e = sensor.settings.detector->full_well_e - (budget.signal.total_e() - dark_e);
  const double s2 = std::log1p(unequal->dcnu * unequal->dcnu);
  return 0.5 * std::erfc((std::log(std::max(room_e, 0.0) / dark_e) + 0.5 * s2) / std::sqrt(2.0 * s2));
}

double middle_um(const Sensor& sensor) { return 0.5 * (sensor.curves.band.lo_um + sensor.curves.band.hi_um); }

/// What the noise of a thermal detector is known by; an NETD at another f-number than the camera's, how it gets there.
std::string given_noise_doc(const ThermalSettings& thermal, const Camera<double>& of) {
  const bool camera = thermal.netd_of == NetdOf::camera;
  std::string doc = thermal.netd_k ? (camera ? "noise of the camera by its NETD" : "noise of the detector by its NETD")
                                   : std::string("noise of the detector by its NEP or D*");
  if (thermal.netd_f_number && of.f_number != *thermal.netd_f_number)
    doc += ": at f/" + mtf::format_double(*thermal.netd_f_number) + ", here f/" + mtf::format_double(of.f_number) +
           ", in proportion to " + (of.cone == Cone::sine ? "4 N^2" : "4 N^2 + 1") + " as [optics] cone = \"" +
           std::string(kConeNames[static_cast<std::size_t>(of.cone)]) + "\" has it";
  return doc + (camera ? ", less the rounding to counts" : "");
}

/// The temporal noise of a thermal detector in volts: the terms of the physics, or the one that is given.
std::vector<BudgetRow> thermal_noise_rows(const Sensor& sensor, const Camera<double>& camera,
                                          const Pixel<double>& pixel, const Budget<double>& b) {
  const ThermalSettings& thermal = *sensor.settings.thermal;
  const double volts = pixel.volts_per_watt;
  const ThermalNoise<double> noise = thermal_noise_of(sensor.settings, pixel, thermal_reference(sensor));
  const double readout = volts * noise.readout_w;
  std::vector<BudgetRow> terms;
  if (thermal.physics())
    terms = {{"thermal_fluctuation", "V", volts * noise.fluctuation_w, "fluctuation of the pixel's temperature"},
             {"johnson", "V", volts * noise.johnson_w, "Johnson noise of its resistance"},
             {"flicker", "V", volts * noise.flicker_w, "1/f noise from lowest_frequency to noise_bandwidth"}};
  else
    terms = {{"detector", "V", std::sqrt(std::max(b.read_e * b.read_e - readout * readout, 0.0)),
              given_noise_doc(thermal, camera)}};
  terms.push_back({"readout", "V", readout, "noise of the readout"});
  terms.push_back({"other", "V", b.other_e, "[flicker], row, column and 3-D noise of the frames"});
  terms.push_back(
      {"quantisation", "V", b.quantisation_e, "rounding to counts, the part that changes from frame to frame"});
  const auto largest = std::ranges::max_element(terms, [](const auto& x, const auto& y) { return x.value < y.value; });
  const std::string name = largest->name;
  const double share = largest->value * largest->value / (b.temporal_e * b.temporal_e);
  std::vector<BudgetRow> all;
  add_rows(all, BudgetGroup::temporal, std::move(terms), true);
  add_rows(all, BudgetGroup::temporal,
           {{"temporal", "V", b.temporal_e, "temporal noise, root sum of squares"},
            {"largest", "", share, "part of the temporal variance that is " + name + ", the largest term"}});
  return all;
}

/// What has warmed from a closing of the shutter to the last frame before the next, as a temperature of the scene.
BudgetRow false_offset(const mtf::System<double>& system, const Sensor& sensor, double signal_per_k) {
  const ShutterEvents events = shutter_events(sensor.settings);
  const CameraEmission cool = emission_of(sensor.settings), warm = warmed(cool, events.warming_k(events.interval - 1));
  const auto volts = [&](const CameraEmission& camera) {
    return own_light(camera_of(system, sensor), pixel_of(system, sensor), own_radiances(sensor.curves, camera))
        .total_e();
  };
  return {"false_offset", "mK", 1e3 * (volts(warm) - volts(cool)) / signal_per_k,
          "what shutter_drift adds from a closing of the shutter to the last frame before the next, as a temperature "
          "of the scene"};
}

/// The surface whose signal, beside `rest_e`, meets an end of the converter; 0 where none is that cold, infinity where
/// none is that hot.
double surface_at_k(const Sensor& sensor, double gain, double rest_e, double end_e) {
  const SensorSettings& settings = sensor.settings;
  Surface surface{0.0, sensor.emissivity, settings.scene ? settings.scene->surroundings_k.value_or(0.0) : 0.0};
  const auto above = [&](double temperature_k) {
    surface.temperature_k = temperature_k;
    return gain * scene_radiance(sensor.curves, surface, sensor.path) + rest_e - end_e;
  };
  double lo = 1e-3, hi = kMostTemperature_k;
  if (!(above(lo) < 0.0)) return 0.0;
  if (!(above(hi) > 0.0)) return mtf::kInfinity;
  while (hi > lo * (1.0 + 1e-12)) {
    const double middle = std::sqrt(lo * hi);
    (above(middle) < 0.0 ? lo : hi) = middle;
  }
  return hi;
}

/// The scenes that the converter takes.
std::vector<BudgetRow> scene_range(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& b) {
  const Signal<double>& s = b.signal;
  const Pixel<double> pixel = pixel_of(system, sensor);
  const double gain = (1.0 + sensor.settings.glare.value_or(VeilingGlare{}).offset) * b.light_share *
                      electrons_per_radiance(camera_of(system, sensor), pixel);
  const PixelRange range = range_numbers(sensor.settings, pixel);
  const auto row = [&](const char* name, double end_e, const char* doc) {
    BudgetRow end{name, "K", surface_at_k(sensor, gain, s.total_e() - s.scene_e, end_e), doc};
    if (end.value > 0.0 && std::isfinite(end.value)) return end;
    end.refused = std::string("no scene is so ") + (end.value > 0.0 ? "hot" : "cold") + " that it gives that count";
    end.value = std::numeric_limits<double>::quiet_NaN();
    return end;
  };
  return {
      row("coldest_scene", range.least_e, "surface from which on counts are above 0; raise adc.offset for colder ones"),
      row("hottest_scene", range.most_e,
          "surface from which on counts are the largest one; raise adc.volts_per_count, or lower "
          "detector.counts_per_kelvin, for hotter ones")};
}

std::vector<BudgetRow> thermal_rows(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& b) {
  const Pixel<double> pixel = pixel_of(system, sensor);
  const ThermalSettings& thermal = *sensor.settings.thermal;
  const Signal<double>& s = b.signal;
  std::vector<BudgetRow> all;
  add_rows(all, BudgetGroup::signal,
           {{"scene", "V", s.scene_e, "signal of the scene"},
            {"path", "V", s.path_e, "signal of the path between scene and camera"},
            {"optics", "V", s.optics_e, "signal of the warm optics"},
            {"stop", "V", s.stop_e, "signal from around the cone of light"},
            {"shutter", "V", s.shutter_e, "signal of the closed shutter, taken off"},
            {"total", "V", s.total_e(), "all signal"},
            {"absorbed", "W", s.total_e() / pixel.volts_per_watt, "absorbed power, less that of the shutter"},
            {"responsivity", "V/W", pixel.volts_per_watt * pixel.quantum_efficiency * thermal_reference(sensor).middle,
             "volts for a watt of incident power at the middle of the band"},
            {"signal_per_k", "V/K", b.signal_per_k, "volts per kelvin of the scene"}});
  for (BudgetRow& row : thermal_noise_rows(sensor, camera_of(system, sensor), pixel, b)) all.push_back(std::move(row));
  add_spatial_rows(all, b, "V", "the offset (dsnu, or its map)");
  add_rows(all, BudgetGroup::sensitivity,
           {{"snr", "", b.snr, "scene / temporal noise"},
            {"netd", "mK", 1e3 * b.netd_k, "noise-equivalent temperature difference, temporal"},
            {"spatial_netd", "mK", 1e3 * b.spatial_netd_k, "the same from the spatial noise"},
            {"nei", "W m^-2", b.nei_ph, "noise-equivalent irradiance, of the scene's spectrum"},
            {"nep", "W", b.nep_w, "incident power at the middle of the band that equals the temporal noise"}});
  if (thermal.heat_capacity_j_k && thermal.conductance_w_k)
    add_rows(all, BudgetGroup::signal,
             {{"time_constant", "s", *thermal.heat_capacity_j_k / *thermal.conductance_w_k,
               "heat capacity / conductance of a pixel"}});
  if (thermal.closes()) add_rows(all, BudgetGroup::signal, {false_offset(system, sensor, b.signal_per_k)});
  for (BudgetRow& row : all) {
    row.refused = refusal_of(b, row.value);
    row.saturated = is_saturated(b, row.value);
  }
  if (sensor.settings.adc) add_rows(all, BudgetGroup::signal, scene_range(system, sensor, b));
  return all;
}

}  // namespace

AtmosphereSettings atmosphere_with(const Sensor& sensor, const Overrides<double>& numbers) {
  AtmosphereSettings settings = *sensor.settings.atmosphere;
  for_each_field(settings, [&](const FieldInfo& info, auto& member) {
    using Member = std::decay_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, double> || std::is_same_v<Member, std::optional<double>>)
      if (const double* value = numbers.find(std::string(kAtmospherePrefix) + std::string(info.name))) member = *value;
  });
  return settings;
}

bool changes_color(std::string_view path) { return path.starts_with(kAtmospherePrefix); }

bool is_spectral(std::string_view path) {
  if (changes_color(path)) return true;
  constexpr std::array<std::string_view, 8> paths{
      "optics.temperature", "optics.stop_temperature", "detector.shutter_temperature",
      "path.transmission",  "path.radiance",           "path.air_temperature",
      "scene.emissivity",   "scene.surroundings"};
  return std::ranges::find(paths, path) != paths.end();
}

double kept_of_flicker(const SensorSettings& settings, int frames) {
  FrameFlicker unit;
  if (settings.thermal) {
    const ThermalSettings& thermal = *settings.thermal;
    if (!thermal.corner_hz || !settings.frame || !settings.frame->frame_time_s) return 0.0;
    const double frame_time_s = *settings.frame->frame_time_s;
    unit = {1.0, *thermal.lowest_hz * frame_time_s, *thermal.bandwidth_hz * frame_time_s};
  } else {
    if (!settings.frame_flicker || !(settings.frame_flicker->octave_e > 0.0)) return 0.0;
    unit = settings.frame_flicker->noise();
  }
  return frame_flicker_mean_variance(unit, frames) / frame_flicker_variance(unit);
}

Path path_with(const Sensor& sensor, const Overrides<double>& numbers) {
  const SensorSettings& settings = sensor.settings;
  if (sensor.air && numbers.any(changes_color)) return sensor.air(atmosphere_with(sensor, numbers));
  Path path = sensor.path;
  set_constant(path.transmission, "path.transmission", numbers, 1.0);
  set_constant(path.radiance, "path.radiance", numbers, std::numeric_limits<double>::max());
  const double* air = numbers.find("path.air_temperature");
  if (settings.path && (air != nullptr || settings.path->air_temperature_k)) {  // air emits what it absorbs
    const Path absorbing = absorbing_path(path.transmission, air != nullptr ? *air : *settings.path->air_temperature_k);
    path.emissivity = absorbing.emissivity;
    path.air_temperature_k = absorbing.air_temperature_k;
  }
  return path;
}

SpectralNumbers<double> spectral_numbers(const Sensor& sensor, const Path& path, double temperature_k, double warmer_k,
                                         const Overrides<double>& numbers) {
  const SensorSettings& settings = sensor.settings;
  const Surface surface = surface_of(sensor, temperature_k, numbers);
  CameraEmission emission = emission_of(settings);
  emission.optics_k = numbers("optics.temperature", emission.optics_k);
  emission.stop_k = numbers("optics.stop_temperature", emission.stop_k);
  emission.shutter_k = numbers("detector.shutter_temperature", emission.shutter_k);
  return {.radiances = band_radiances(sensor.curves, surface, path, emission),
          .per_k = scene_derivative(sensor.curves, surface, path),
          .contrast = warmer_k == 0.0 ? 0.0 : scene_difference(sensor.curves, surface, path, warmer_k),
          .quantum_efficiency = mean_quantum_efficiency(sensor.curves, surface, path),
          .thermal = thermal_reference(sensor),
          .cold_flat = flat_radiance(sensor, &CorrectionSettings::cold_k),
          .hot_flat = flat_radiance(sensor, &CorrectionSettings::hot_k)};
}

SpectralNumbers<double> behind_path(SpectralNumbers<double> own, const Sensor& sensor, const Path& path,
                                    double temperature_k, const Overrides<double>& numbers) {
  const Surface surface = surface_of(sensor, temperature_k, numbers);
  own.radiances.scene = scene_radiance(sensor.curves, surface, path);
  own.radiances.path = weighted_path_radiance(sensor.curves, path);
  own.per_k = scene_derivative(sensor.curves, surface, path);
  return own;
}

SensorSettings budget_settings(const Sensor& sensor) {
  SensorSettings settings = sensor.settings;
  if (!settings.nonuniformity) return settings;
  NonuniformitySettings& unequal = *settings.nonuniformity;
  if (sensor.responsivity) {
    unequal.prnu = mtf::statistics(sensor.responsivity->view()).std;
    unequal.prnu_row = unequal.prnu_column = 0.0;
  }
  if (sensor.offset) unequal.dsnu_e = mtf::statistics(sensor.offset->view()).std;
  return settings;
}

std::vector<std::string> budget_notes(const Sensor& sensor, const Budget<double>& budget) {
  std::vector<std::string> notes;
  if (std::string said = words(budget.dither); !said.empty()) notes.push_back(std::move(said));
  if (const auto& noise = sensor.settings.noise; noise && !noise->shot)
    notes.emplace_back(
        "[noise] shot = false leaves shot noise out of simulated frames; the budget counts it, as light and dark "
        "current have it whatever is simulated");
  if (budget.slope != 1.0 && !budget.saturation.saturated())
    notes.push_back("[nonlinearity]: at this charge the response rises by " + mtf::three_digits(budget.slope) +
                    " of what the charge does; noise behind it (read, reset, other, quantisation, dsnu) stands here as "
                    "charge, that of the readout divided by this slope");
  const SensorSettings& settings = sensor.settings;
  if (settings.glare || settings.ghost)
    notes.push_back(
        std::string(settings.glare ? "[veiling_glare]" : "") + (settings.glare && settings.ghost ? " and " : "") +
        (settings.ghost ? "[ghost]" : "") +
        ": the budget is that of a uniform scene, and signal_per_k, the NETDs and the target are those of a "
        "small target before it, whose contrast stray light leaves at " +
        mtf::three_digits(budget.contrast_share) + " of the scene's");
  if (settings.vignetting && budget.light_share != 1.0)
    notes.push_back("[vignetting]: the place has " + mtf::three_digits(budget.light_share) +
                    " of the light of the axis");
  if (settings.defects || settings.blinking)
    notes.push_back(std::string(settings.defects ? "[defects]" : "") +
                    (settings.defects && settings.blinking ? " and " : "") + (settings.blinking ? "[blinking]" : "") +
                    ": the budget is that of a pixel that is neither; simulated frames have the noise of those too");
  if (const double share = filled_by_dark(sensor, budget); share > 3.2e-5 && !budget.saturation.saturated())
    notes.push_back("nonuniformity.dcnu gives " + mtf::three_digits(1e2 * share) +
                    " % of the pixels so much dark current that they fill the well; the figures are those of the "
                    "pixels for which it leaves room");
  const auto& thermal = sensor.settings.thermal;
  if (thermal && thermal->counts_per_k)
    notes.emplace_back(
        "detector.counts_per_kelvin leaves open how many volts a count is, and the budget calls it 1 uV: volts and V/W "
        "have no meaning of their own, figures in kelvin, watts and counts hold");
  if (thermal && thermal->corner_hz && sensor.settings.correction)
    notes.emplace_back(
        "[correction] together with detector.corner: the spatial noise is that of frames long after the flat frames; "
        "simulated flat frames lie right before frame 0, whose neighbours share their 1/f noise and are more uniform");
  if (sensor.responsivity) {
    const mtf::Statistics factors = mtf::statistics(sensor.responsivity->view());
    if (!has_mean(*sensor.responsivity, factors, 1.0, 1.0))
      notes.push_back(
          "the mean of nonuniformity.responsivity is " + mtf::three_digits(factors.mean) +
          "; the budget is that of a pixel whose factor is 1, and its prnu is the standard deviation of the factors, " +
          mtf::three_digits(factors.std) + ", not divided by their mean");
  }
  if (sensor.offset) {
    const mtf::Statistics offset = mtf::statistics(sensor.offset->view());
    if (!has_mean(*sensor.offset, offset, 0.0, offset.std))
      notes.push_back("the mean of nonuniformity.offset is " + mtf::three_digits(offset.mean) + " " +
                      std::string(signal_unit(sensor)) +
                      ", which the budget leaves out of the mean signal at the converter");
  }
  return notes;
}

Budget<double> budget_of(const mtf::System<double>& system, const Sensor& sensor, double temperature_k) {
  require_consistent(system, sensor);
  pixel_of(system, sensor);  // throws where there is no [detector]
  return sensor_budget(system, budget_settings(sensor), spectral_numbers(sensor, sensor.path, temperature_k),
                       flicker_rms_e(system, sensor.settings), {},
                       light_share(system, sensor.settings, sensor.vignetting.get()));
}

double flicker_rms_e(const mtf::System<double>& system, const SensorSettings& settings) {
  if (!settings.flicker) return 0.0;
  // A sensor without a format gets that of a common detector: 1/f noise grows with the logarithm of the size only.
  const std::int64_t columns = system.frame.columns > 0 ? system.frame.columns : 640;
  const std::int64_t rows = system.frame.rows > 0 ? system.frame.rows : 512;
  return std::sqrt(flicker_variance(*settings.flicker, columns, rows));
}

ThermalReference<double> thermal_reference(const Sensor& sensor) {
  const auto& thermal = sensor.settings.thermal;
  if (!thermal) return {};
  ThermalReference<double> reference;
  for (const Spectrum& curve : sensor.curves.quantum_efficiency) reference.middle *= evaluate(curve, middle_um(sensor));
  if (thermal->netd_temperature_k) {
    SpectralCamera bare = sensor.curves;  // the optics of the reference are its one transmission
    bare.optics.clear();
    bare.cold_filter.clear();
    if (thermal->netd_shortest_um && thermal->netd_longest_um && *thermal->netd_shortest_um < *thermal->netd_longest_um)
      bare.band = {*thermal->netd_shortest_um, *thermal->netd_longest_um};
    reference.per_k = scene_derivative(bare, {.temperature_k = *thermal->netd_temperature_k}, {});
  }
  return reference;
}

double dstar_of(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  Pixel<double> pixel = pixel_of(system, sensor);
  if (pixel.thermal()) {
    const auto& bandwidth_hz = sensor.settings.thermal->bandwidth_hz;
    const double none = std::numeric_limits<double>::quiet_NaN();
    return bandwidth_hz ? dstar_from_nep_jones(budget.nep_w, pixel.area_m2(), *bandwidth_hz, 1.0) : none;
  }
  const double wavelength_um = middle_um(sensor);
  for (const Spectrum& curve : sensor.curves.quantum_efficiency)
    pixel.quantum_efficiency *= evaluate(curve, wavelength_um);
  return dstar_jones(pixel, budget.temporal_e, wavelength_um);
}

std::vector<BudgetRow> budget_rows(const mtf::System<double>& system, const Sensor& sensor,
                                   const Budget<double>& budget) {
  std::vector<BudgetRow> all = sensor.settings.thermal ? thermal_rows(system, sensor, budget) : rows(budget);
  all.push_back(dstar_row(system, sensor, budget));
  if (sensor.settings.thermal && !sensor.settings.thermal->bandwidth_hz)
    all.back().refused = "no detector.noise_bandwidth";
  return all;
}

BudgetRow dstar_row(const mtf::System<double>& system, const Sensor& sensor, const Budget<double>& budget) {
  const double dstar = dstar_of(system, sensor, budget);
  return {"dstar",
          "cm Hz^1/2 W^-1",
          dstar,
          "D* at " + mtf::format_double(middle_um(sensor)) + " um, the middle of the band, temporal noise",
          refusal_of(budget, dstar),
          is_saturated(budget, dstar)};
}

}  // namespace radiometry
