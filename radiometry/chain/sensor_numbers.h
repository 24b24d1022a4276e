// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the camera equation and the budget take from a sensor file, as numbers of any scalar, so that studies
// differentiate through detector and converter as they do through the OTF.

#include <array>
#include <string>
#include <string_view>

#include "mtf/words.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/performance/overrides.h"
#include "radiometry/performance/thermal_detector.h"

namespace radiometry {

// What the chain and the budget take from [detector] kind = "thermal": volts for a watt and the noise, in any scalar.

/// What the curve of the absorptance says; without a curve its middle is 1.
template <class S>
struct ThermalReference {
  S per_k{};      ///< dL/dT in watts at netd_temperature, weighted by the curve
  S middle{1.0};  ///< at the middle of the band
};

/// The numbers of `sensor_settings` that these functions read.
inline constexpr auto kThermalNumbers = std::to_array<std::string_view>(
    {"detector.absorptance", "detector.fill_factor", "detector.counts_per_kelvin", "detector.responsivity",
     "detector.noise_bandwidth", "detector.readout_noise", "detector.netd", "detector.netd_f_number",
     "detector.netd_transmission", "detector.nep", "detector.nep_density", "detector.dstar", "detector.heat_capacity",
     "detector.conductance", "detector.resistance", "detector.tcr", "detector.bias", "detector.corner",
     "detector.lowest_frequency"});

namespace detail {

template <class S>
S given(const Overrides<S>& numbers, std::string_view path, const std::optional<double>& value) {
  return numbers(path, value.value_or(0.0));
}

template <class S>
ThermalBody<S> body_numbers(const ThermalSettings& s, const Overrides<S>& numbers) {
  return {.heat_capacity_j_k = given(numbers, "detector.heat_capacity", s.heat_capacity_j_k),
          .conductance_w_k = given(numbers, "detector.conductance", s.conductance_w_k),
          .temperature_k = given(numbers, "detector.temperature", s.temperature_k)};
}

template <class S>
BolometerReadout<S> readout_numbers(const ThermalSettings& s, const Overrides<S>& numbers) {
  return {.resistance_ohm = given(numbers, "detector.resistance", s.resistance_ohm),
          .tcr_per_k = given(numbers, "detector.tcr", s.tcr_per_k),
          .bias_v = given(numbers, "detector.bias", s.bias_v),
          .corner_hz = given(numbers, "detector.corner", s.corner_hz),
          .lowest_hz = given(numbers, "detector.lowest_frequency", s.lowest_hz),
          .readout_v = numbers("detector.readout_noise", s.readout_v),
          .bandwidth_hz = given(numbers, "detector.noise_bandwidth", s.bandwidth_hz)};
}

}  // namespace detail

/// Throws as require_bolometer for numbers of a design that no pixel can have.
template <class S>
void require_physics(const ThermalSettings& s, const S& absorptance, const S& area_m2, const Overrides<S>& numbers) {
  const ThermalBody<S> body = detail::body_numbers(s, numbers);
  const BolometerReadout<S> readout = detail::readout_numbers(s, numbers);
  const auto value = [](const S& x) { return mtf::value_of(x); };
  require_bolometer("detector",
                    {.heat_capacity_j_k = value(body.heat_capacity_j_k),
                     .conductance_w_k = value(body.conductance_w_k),
                     .temperature_k = value(body.temperature_k)},
                    {.resistance_ohm = value(readout.resistance_ohm),
                     .tcr_per_k = value(readout.tcr_per_k),
                     .bias_v = value(readout.bias_v),
                     .corner_hz = value(readout.corner_hz),
                     .lowest_hz = value(readout.lowest_hz),
                     .readout_v = value(readout.readout_v),
                     .bandwidth_hz = value(readout.bandwidth_hz)},
                    value(absorptance), value(area_m2));
}

/// Absorbed power for a kelvin at the reference of the NETD. `absorptance`: without the curve. `cone`: of [optics].
template <class S>
S reference_watts_per_k(const ThermalSettings& s, const S& area_m2, const S& absorptance, Cone cone,
                        const ThermalReference<S>& reference, const Overrides<S>& numbers) {
  const Camera<S> camera{.f_number = detail::given(numbers, "detector.netd_f_number", s.netd_f_number),
                         .transmission = detail::given(numbers, "detector.netd_transmission", s.netd_transmission),
                         .cone = cone};
  return absorbed_per_k(camera, area_m2, absorptance, reference.per_k);
}

/// Volts for a watt of absorbed power. `middle_absorptance`: the whole one at the middle of the band. `watts_per_k`:
/// reference_watts_per_k(), `volts_per_count`: of the converter; for a responsivity that is given in counts per kelvin.
template <class S>
S volts_per_watt(const ThermalSettings& s, const S& middle_absorptance, const S& watts_per_k, const S& volts_per_count,
                 const Overrides<S>& numbers = {}) {
  if (s.counts_per_k)
    return detail::given(numbers, "detector.counts_per_kelvin", s.counts_per_k) * volts_per_count / watts_per_k;
  if (s.physics())
    return bolometer_responsivity_v_w(detail::body_numbers(s, numbers), detail::readout_numbers(s, numbers));
  return detail::given(numbers, "detector.responsivity", s.responsivity_v_w) / middle_absorptance;
}

/// The noise as absorbed power. `absorptance`: the number without the curve. `cone`: of [optics].
template <class S>
ThermalNoise<S> thermal_noise(const ThermalSettings& s, const S& area_m2, const S& absorptance, const S& volts_per_watt,
                              Cone cone, const ThermalReference<S>& reference, const Overrides<S>& numbers = {}) {
  if (s.physics()) return bolometer_noise(detail::body_numbers(s, numbers), detail::readout_numbers(s, numbers));
  const S bandwidth_hz = detail::given(numbers, "detector.noise_bandwidth", s.bandwidth_hz);
  const S middle = absorptance * reference.middle;
  const auto white = [&](const S& watts, const std::optional<double>& own_hz) {
    return own_hz ? in_bandwidth(watts, S(*own_hz), bandwidth_hz) : watts;
  };
  ThermalNoise<S> noise;
  if (s.netd_k) {
    const S netd_k = detail::given(numbers, "detector.netd", s.netd_k);
    const S watts_per_k = reference_watts_per_k(s, area_m2, absorptance, cone, reference, numbers);
    noise.given_w = white(nep_from_netd_w(netd_k, watts_per_k), s.netd_bandwidth_hz);
  } else if (s.nep_w) {
    noise.given_w = white(S(detail::given(numbers, "detector.nep", s.nep_w) * middle), s.nep_bandwidth_hz);
  } else if (s.nep_density) {
    noise.given_w = detail::given(numbers, "detector.nep_density", s.nep_density) * middle * detail::root(bandwidth_hz);
  } else {
    noise.given_w =
        nep_from_dstar_w(detail::given(numbers, "detector.dstar", s.dstar_jones), area_m2, bandwidth_hz, middle);
  }
  noise.readout_w = numbers("detector.readout_noise", s.readout_v) / volts_per_watt;
  return noise;
}

/// The numbers that the functions below read from overrides.
inline constexpr std::array<std::string_view, 36> kBudgetNumbers{"optics.transmission",
                                                                 "optics.cold_transmission",
                                                                 "optics.emissivity",
                                                                 "optics.obscuration_emissivity",
                                                                 "optics.stop_emissivity",
                                                                 "detector.width",
                                                                 "detector.height",
                                                                 "detector.dark_current",
                                                                 "detector.full_well",
                                                                 "detector.quantum_efficiency",
                                                                 "detector.capacitance",
                                                                 "detector.temperature",
                                                                 "detector.reset_noise",
                                                                 "detector.read_noise",
                                                                 "detector.other_noise",
                                                                 "adc.electrons_per_count",
                                                                 "adc.volts_per_count",
                                                                 "adc.offset",
                                                                 "frame_flicker.octave",
                                                                 "noise.row",
                                                                 "noise.column",
                                                                 "noise.fixed_row",
                                                                 "noise.fixed_column",
                                                                 "noise_3d.t",
                                                                 "noise_3d.tv",
                                                                 "noise_3d.th",
                                                                 "noise_3d.tvh",
                                                                 "noise_3d.v",
                                                                 "noise_3d.h",
                                                                 "noise_3d.vh",
                                                                 "nonuniformity.prnu",
                                                                 "nonuniformity.prnu_row",
                                                                 "nonuniformity.prnu_column",
                                                                 "nonuniformity.dsnu",
                                                                 "nonuniformity.dcnu",
                                                                 "narcissus.depth"};

/// The f-number is 0 where the sensor has none; factors that are given as curves are 1.
template <class S>
Camera<S> camera_numbers(const mtf::System<S>& system, const SensorSettings& settings,
                         const Overrides<S>& numbers = {}) {
  const mtf::Context<S> context = system.context();
  Camera<S> camera{.f_number = mtf::f_number_of<S>({}, context), .obscuration = mtf::obscuration_of<S>({}, context)};
  const OpticsSettings optics = settings.optics.value_or(OpticsSettings{});
  const auto factor = [&](std::string_view path, const NumberOrFile& given) {
    return given.file.empty() ? numbers(path, given.number) : S(1);
  };
  camera.transmission = factor("optics.transmission", optics.transmission);
  camera.cold_transmission = factor("optics.cold_transmission", optics.cold_transmission);
  camera.optics_emissivity = numbers("optics.emissivity", optics.emissivity);
  camera.obscuration_emissivity = numbers("optics.obscuration_emissivity", optics.obscuration_emissivity);
  camera.stop_emissivity = numbers("optics.stop_emissivity", optics.stop_emissivity);
  camera.cone = optics.cone;
  if (settings.thermal) camera.shutter_place = settings.thermal->shutter_place;
  return camera;
}

/// From a frame to the next: as given, else the integration time.
template <class S>
S frame_time_s(const mtf::System<S>& system, const SensorSettings& settings) {
  return settings.frame && settings.frame->frame_time_s ? S(*settings.frame->frame_time_s)
                                                        : system.frame.integration_time_s;
}

/// Why a pixel cannot collect light for so long in each frame; "" where it can.
inline std::string frame_time_problem(const mtf::System<double>& system, const SensorSettings& settings) {
  constexpr double kUnits = 1e-12;  // relative: what units round
  const double given = system.frame.integration_time_s, most = frame_time_s(system, settings);
  if (settings.thermal || !(most < (1.0 - kUnits) * given)) return "";
  return "frame.frame_time: " + mtf::significant(most, 12) + " s is shorter than frame.integration_time, " +
         mtf::significant(given, 12) + " s; give the time from one frame to the next";
}

/// Electrons (volts of a thermal detector) of one count: as given, or the full well over the counts that the offset
/// leaves. It is 0 without [adc].
template <class S>
S electrons_per_count(const SensorSettings& settings, const S& full_well_e, const Overrides<S>& numbers = {}) {
  if (!settings.adc) return S(0);
  const AdcSettings& adc = *settings.adc;
  const std::string_view path = settings.thermal ? "adc.volts_per_count" : "adc.electrons_per_count";
  if (adc.electrons_per_count || numbers.find(path) != nullptr)
    return numbers(path, adc.electrons_per_count.value_or(0.0));
  const double most = Adc{.bits = adc.bits}.most_counts();
  return full_well_e / (S(most) - numbers("adc.offset", adc.offset_counts));
}

/// The active area is the pitch unless [detector] gives its size; a width alone is that of a square. `reference`: of a
/// thermal detector.
template <class S>
Pixel<S> pixel_numbers(const mtf::System<S>& system, const SensorSettings& settings, const Overrides<S>& numbers = {},
                       const ThermalReference<S>& reference = {}) {
  const DetectorSettings detector = settings.detector.value_or(DetectorSettings{});
  const auto size = [&](std::string_view path, const std::optional<double>& given) -> std::optional<S> {
    if (!given && numbers.find(path) == nullptr) return std::nullopt;
    return numbers(path, given.value_or(0.0));
  };
  const std::optional<S> width_um = size("detector.width", detector.width_um);
  const S side_um = detector.square ? width_um.value_or(system.frame.pitch_y_um) : system.frame.pitch_y_um;
  Pixel<S> pixel{.width_um = width_um.value_or(system.frame.pitch_x_um),
                 .height_um = size("detector.height", detector.height_um).value_or(side_um),
                 .integration_s = system.frame.integration_time_s,
                 .dark_e_s = numbers("detector.dark_current", detector.dark_e_s),
                 .full_well_e = numbers("detector.full_well", detector.full_well_e)};
  if (settings.thermal && settings.thermal->fill_factor) {
    const S side = detail::root(numbers("detector.fill_factor", *settings.thermal->fill_factor));
    pixel.width_um = system.frame.pitch_x_um * side;
    pixel.height_um = system.frame.pitch_y_um * side;
  }
  if (detector.quantum_efficiency.file.empty())
    pixel.quantum_efficiency = numbers(settings.thermal ? "detector.absorptance" : "detector.quantum_efficiency",
                                       detector.quantum_efficiency.number);
  if (settings.thermal) {
    const S absorptance = pixel.quantum_efficiency * reference.middle;
    if (settings.thermal->physics() && !numbers.empty())
      require_physics(*settings.thermal, absorptance, S(pixel.area_m2()), numbers);
    pixel.flux = flux_of(settings);
    const Cone cone = settings.optics.value_or(OpticsSettings{}).cone;
    const S watts_per_k = settings.thermal->counts_per_k
                              ? reference_watts_per_k(*settings.thermal, S(pixel.area_m2()), pixel.quantum_efficiency,
                                                      cone, reference, numbers)
                              : S(0);
    pixel.volts_per_watt = volts_per_watt(*settings.thermal, absorptance, watts_per_k,
                                          electrons_per_count(settings, pixel.full_well_e, numbers), numbers);
    pixel.integration_s = S(1);  // the signal follows the power, not its sum over a time
  }
  return pixel;
}

/// Counts at which values are 0, less the part of a count that rounding adds.
template <class S>
S zero_counts(const AdcSettings& adc, const Overrides<S>& numbers) {
  return numbers("adc.offset", adc.offset_counts) + S(adc.rounding == Rounding::nearest ? 0.5 : 0.0);
}

/// The electrons of the well from which on counts are the largest one; infinite without [adc].
template <class S>
S converter_end_e(const SensorSettings& settings, const Pixel<S>& pixel, const Overrides<S>& numbers = {}) {
  if (!settings.adc) return S(mtf::kInfinity);
  const S counts = S(Adc{.bits = settings.adc->bits}.most_counts() + 1.0) - zero_counts(*settings.adc, numbers);
  const S end_e = counts * electrons_per_count(settings, pixel.full_well_e, numbers);
  const double well_e = mtf::value_of(pixel.full_well_e);
  if (!settings.nonlinearity || !std::isfinite(well_e)) return end_e;
  // Newton's step from the inverse, which changes it by rounding alone, has its derivatives.
  const S charge_e(Response(*settings.nonlinearity, well_e).inverse(mtf::value_of(end_e)));
  const Bow<S> bow(*settings.nonlinearity, pixel.full_well_e, charge_e);
  return charge_e + (end_e - charge_e - bow.value) / (S(1) + bow.slope);
}

/// The ends of the converter as electrons of the well, where they are held by adc.h.
template <class S>
PixelRange range_numbers(const SensorSettings& settings, const Pixel<S>& pixel, const Overrides<S>& numbers = {}) {
  PixelRange range;
  if (!settings.adc) return range;
  const S step_e = electrons_per_count(settings, pixel.full_well_e, numbers);
  range.least_e = -mtf::value_of(S(zero_counts(*settings.adc, numbers) * step_e));
  range.most_e = mtf::value_of(converter_end_e(settings, pixel, numbers));
  const double well_e = mtf::value_of(pixel.full_well_e);
  if (settings.nonlinearity && std::isfinite(well_e))
    range.least_e = Response(*settings.nonlinearity, well_e).inverse(range.least_e);
  return range;
}

/// The noise of a thermal pixel as absorbed power.
template <class S>
ThermalNoise<S> thermal_noise_of(const SensorSettings& settings, const Pixel<S>& pixel,
                                 const ThermalReference<S>& reference, const Overrides<S>& numbers = {}) {
  const Cone cone = settings.optics.value_or(OpticsSettings{}).cone;
  return thermal_noise(*settings.thermal, pixel.area_m2(), pixel.quantum_efficiency, pixel.volts_per_watt, cone,
                       reference, numbers);
}

/// Rms volts of a thermal pixel and its readout. An NETD of the camera has the rounding to counts in it already; it is
/// taken off here, since the budget and the converter of simulated frames add it.
template <class S>
S thermal_volts(const SensorSettings& settings, const Pixel<S>& pixel, const ThermalReference<S>& reference,
                const Overrides<S>& numbers = {}) {
  const S volts = pixel.volts_per_watt * thermal_noise_of(settings, pixel, reference, numbers).total_w();
  if (settings.thermal->netd_of == NetdOf::focal_plane) return volts;
  const S step = electrons_per_count(settings, pixel.full_well_e, numbers);
  // Rounding does not follow the bandwidth: its part of the NETD is taken off before the rest is scaled.
  const auto& stated_hz = settings.thermal->netd_bandwidth_hz;
  const S scale =
      stated_hz ? S(numbers("detector.noise_bandwidth", settings.thermal->bandwidth_hz.value_or(0.0)) / S(*stated_hz))
                : S(1);
  if (!(mtf::value_of(step) > 0.0)) return volts;
  const S whole2 = volts * volts / (scale * step * step);
  return detail::root(scale) * step * mtf::lift(noise_before_rounding(mtf::value_of(whole2)), whole2);
}

/// Variance of a photon detector's 1/f noise from frame to frame.
template <class S>
S slow_variance(const SensorSettings& settings, const Overrides<S>& numbers) {
  const FlickerOctaves given = settings.frame_flicker.value_or(FlickerOctaves{});
  const S octave = numbers("frame_flicker.octave", given.octave_e);
  return octave * octave * S(given.octaves());
}

/// All temporal and spatial terms. `flicker_e`: rms of the 1/f noise over the detector. `reference`: of a thermal
/// detector.
template <class S>
NoiseTerms<S> noise_numbers(const SensorSettings& settings, const Pixel<S>& pixel, double flicker_e,
                            const Overrides<S>& numbers = {}, const ThermalReference<S>& reference = {}) {
  const DetectorSettings detector = settings.detector.value_or(DetectorSettings{});
  const NoiseSettings lines = settings.noise.value_or(NoiseSettings{});
  const Noise3d cube = settings.noise_3d.value_or(Noise3d{});
  const NonuniformitySettings unequal = settings.nonuniformity.value_or(NonuniformitySettings{});
  const auto root_sum = [](std::initializer_list<S> rms) {
    S sum{};
    for (const S& value : rms) sum += value * value;
    return detail::root(sum);
  };
  const S* capacitance = numbers.find("detector.capacitance");
  const S* temperature = numbers.find("detector.temperature");
  const bool reset = detector.capacitance_f && detector.temperature_k;
  const S reset_e = reset ? reset_noise_e(capacitance != nullptr ? *capacitance : S(*detector.capacitance_f),
                                          temperature != nullptr ? *temperature : S(*detector.temperature_k))
                          : numbers("detector.reset_noise", detector.reset_e);
  return {
      .read_e = settings.thermal ? thermal_volts(settings, pixel, reference, numbers)
                                 : numbers("detector.read_noise", detector.read_e),
      .reset_e = reset_e,
      .other_e = root_sum({numbers("detector.other_noise", detector.other_e), S(flicker_e),
                           detail::root(slow_variance(settings, numbers)), numbers("noise.row", lines.row_e),
                           numbers("noise.column", lines.column_e), numbers("noise_3d.t", cube.t),
                           numbers("noise_3d.tv", cube.tv), numbers("noise_3d.th", cube.th),
                           numbers("noise_3d.tvh", cube.tvh)}),
      .step_e = electrons_per_count(settings, pixel.full_well_e, numbers),
      .prnu =
          root_sum({numbers("nonuniformity.prnu", unequal.prnu), numbers("nonuniformity.prnu_row", unequal.prnu_row),
                    numbers("nonuniformity.prnu_column", unequal.prnu_column)}),
      .dsnu_e = root_sum({numbers("nonuniformity.dsnu", unequal.dsnu_e), numbers("noise.fixed_row", lines.fixed_row_e),
                          numbers("noise.fixed_column", lines.fixed_column_e), numbers("noise_3d.v", cube.v),
                          numbers("noise_3d.h", cube.h), numbers("noise_3d.vh", cube.vh)}),
      .dcnu_e = numbers("nonuniformity.dcnu", unequal.dcnu) * pixel.dark_e_s * pixel.integration_s};
}

}  // namespace radiometry
