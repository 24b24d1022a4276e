// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the chain and the budget take from [detector] kind = "thermal": volts for a watt and the noise, in any scalar.

#include <array>

#include "radiometry/chain/sensor_settings.h"
#include "radiometry/performance/overrides.h"
#include "radiometry/performance/thermal_detector.h"

namespace radiometry {

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

}  // namespace radiometry
