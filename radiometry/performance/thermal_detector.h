// SPDX-License-Identifier: Apache-2.0
#pragma once

// A detector that measures how much its pixels warm: microbolometer, thermopile, pyroelectric. A pixel of heat capacity
// C hangs on legs of thermal conductance G (legs, gas and radiation together) and absorbs the power P:
//   warming            C d(dT)/dt + G dT = P;  dT = P/G in the steady state, time constant tau = C/G
//   power of a scene   dP/dT_scene = absorptance x irradiance(dL/dT) x A,  L in watts, irradiance as in signal.h: the
//                      cone of light is that of Camera::cone here and wherever an NETD is turned into a power
// Noise is a power too, the NEP: the absorbed power that changes the signal by as much as the rms noise. Its terms,
// with B the noise bandwidth of the readout:
//   temperature fluctuation   4 k T^2 G, W^2/Hz, at frequencies below 1/(2 pi tau); k T^2/C for the temperature itself
//   Johnson                   4 k T R, V^2/Hz, of the resistance
//   1/f                       Johnson's density x corner/f, from `lowest` to B: corner x ln(B/lowest) times
//                             that density
//   readout                   volts rms, as given
// Volts become a power by the responsivity. A bolometer at constant current has V_bias |alpha| / G volts for a watt
// that it absorbs, alpha the temperature coefficient of its resistance; electrothermal feedback is left out.
//   D*   = sqrt(A B) / NEP          NETD = NEP / (dP/dT_scene)
// Which power: NEP, responsivity and power per kelvin are those of *absorbed* power here. Data sheets mean *incident*
// power with NEP, D* and responsivity: functions and rows that take or give such a figure say so and have the
// absorptance as an argument. NETD is free of the distinction. The least noise of all is that of radiation: a pixel of
// emissivity eps = absorptance that exchanges heat with its hemisphere through its front side alone has G = 4 eps sigma
// A T^3, and with a background of another temperature
//   D* = sqrt(eps / (8 k sigma (T_detector^5 + T_background^5))),  of incident power.
// (Kruse and Skatrud, Uncooled Infrared Imaging Arrays and Systems, ch. 2; Rogalski, Infrared Detectors, ch. 3.)

#include <cmath>

#include "radiometry/fields.h"
#include "radiometry/light/constants.h"
#include "radiometry/performance/sensitivity.h"

namespace radiometry {

/// The pixel as a body that warms.
template <class S>
struct ThermalBody {
  S heat_capacity_j_k{};
  S conductance_w_k{};
  S temperature_k{300};

  S time_constant_s() const { return heat_capacity_j_k / conductance_w_k; }

  static constexpr auto fields() {
    return std::tuple{
        row_above_zero(&ThermalBody::heat_capacity_j_k, "heat_capacity", "J/K", 1.0, "heat capacity of a pixel"),
        row_above_zero(&ThermalBody::conductance_w_k, "conductance", "W/K", 1.0,
                       "thermal conductance from a pixel to its surroundings"),
        row_above_zero(&ThermalBody::temperature_k, "temperature", "K", 1e4, "temperature of the pixels")};
  }
};

/// A resistance whose voltage at constant current is read.
template <class S>
struct BolometerReadout {
  S resistance_ohm{};
  S tcr_per_k{};  ///< temperature coefficient of the resistance; its sign makes no difference here
  S bias_v{};
  S corner_hz{};     ///< of 1/f noise, where its density is Johnson's; 0: none
  S lowest_hz{};     ///< frequency from which on 1/f noise counts; slower drift is corrected
  S readout_v{};     ///< rms noise of what follows
  S bandwidth_hz{};  ///< noise bandwidth; 1/(2 t) of an integration over t

  static constexpr auto fields() {
    using T = BolometerReadout;
    constexpr double kAny = std::numeric_limits<double>::max();
    return std::tuple{
        row_above_zero(&T::resistance_ohm, "resistance", "ohm", 1e12, "resistance of a pixel"),
        row_between(&T::tcr_per_k, "tcr", "1/K", -10.0, 10.0, "temperature coefficient of the resistance"),
        row_above_zero(&T::bias_v, "bias", "V", 1e6, "voltage across a pixel while it is read"),
        row_between(&T::corner_hz, "corner", "Hz", 0.0, kAny, "frequency at which 1/f noise equals Johnson noise"),
        row_between(&T::lowest_hz, "lowest_frequency", "Hz", 0.0, kAny, "from which on 1/f noise counts"),
        row_between(&T::readout_v, "readout_noise", "V", 0.0, 1e6, "noise of the readout, rms"),
        row_above_zero(&T::bandwidth_hz, "noise_bandwidth", "Hz", kAny, "noise bandwidth of the readout")};
  }
};

/// Noise of a pixel, W rms of absorbed power. Where the noise is given as a whole it is `given`.
template <class S>
struct ThermalNoise {
  S fluctuation_w{}, johnson_w{}, flicker_w{}, readout_w{}, given_w{};

  S total_w() const {
    return detail::root(S(fluctuation_w * fluctuation_w + johnson_w * johnson_w + flicker_w * flicker_w +
                          readout_w * readout_w + given_w * given_w));
  }
};

/// Absorbed power for one kelvin of the scene, W/K. `radiance_per_k` is dL/dT in watts, weighted by all curves
/// (scene_derivative); `absorptance` is the number that is not among them.
template <class S>
S absorbed_per_k(const Camera<S>& camera, const S& area_m2, const S& absorptance, const S& radiance_per_k) {
  return irradiance(camera, radiance_per_k) * area_m2 * absorptance;
}

/// NETD in K of an absorbed noise power, and back.
template <class S>
S netd_from_nep_k(const S& nep_w, const S& watts_per_k) {
  return nep_w / watts_per_k;
}
template <class S>
S nep_from_netd_w(const S& netd_k, const S& watts_per_k) {
  return netd_k * watts_per_k;
}

/// White noise of one bandwidth in another one.
template <class S>
S in_bandwidth(const S& rms, const S& from_hz, const S& to_hz) {
  return rms * detail::root(S(to_hz / from_hz));
}

/// Absorbed noise power of a D* in cm sqrt(Hz)/W of incident power, and back.
template <class S>
S nep_from_dstar_w(const S& dstar_jones, const S& area_m2, const S& bandwidth_hz, const S& absorptance) {
  return S(100) * detail::root(S(area_m2 * bandwidth_hz)) * absorptance / dstar_jones;
}
template <class S>
S dstar_from_nep_jones(const S& nep_w, const S& area_m2, const S& bandwidth_hz, const S& absorptance) {
  return S(100) * detail::root(S(area_m2 * bandwidth_hz)) * absorptance / nep_w;
}

/// Conductance by radiation of the front side alone, W/K: the least that a pixel can have.
template <class S>
S radiation_conductance_w_k(const S& emissivity, const S& area_m2, const S& temperature_k) {
  return S(4 * kStefanBoltzmann_w_m2_k4) * emissivity * area_m2 * temperature_k * temperature_k * temperature_k;
}

/// D* of incident power where radiation is the only noise, cm sqrt(Hz)/W.
template <class S>
S radiation_limit_jones(const S& emissivity, const S& detector_k, const S& background_k) {
  const auto fifth = [](const S& t) { return S(t * t * t * t * t); };
  return S(100) * detail::root(S(emissivity / (S(8 * kBoltzmann_j_k * kStefanBoltzmann_w_m2_k4) *
                                               (fifth(detector_k) + fifth(background_k)))));
}

/// Density of the temperature fluctuation as absorbed power, W^2/Hz, at low frequencies.
template <class S>
S fluctuation_density_w2_hz(const ThermalBody<S>& body) {
  return S(4 * kBoltzmann_j_k) * body.temperature_k * body.temperature_k * body.conductance_w_k;
}

/// The bandwidth in Hz in which a readout of noise bandwidth B, a mean over t = 1/(2 B), sees the temperature
/// fluctuation, which follows the time constant: (1/(4 tau)) 2 (x - 1 + e^-x)/x^2, x = t/tau. It is B for a slow
/// readout and 1/(4 tau) for a fast one, whatever its own bandwidth.
template <class S>
S fluctuation_bandwidth_hz(const S& time_constant_s, const S& bandwidth_hz) {
  using std::exp;
  const S x = S(0.5) / (bandwidth_hz * time_constant_s);
  S shape;
  if (mtf::value_of(x) < 0.5) {  // the difference would lose digits: sum over n of 2 (-x)^n / (n + 2)!
    S term(1);
    shape = S(0);
    for (int n = 0; n < 16; ++n) {
      shape += term;
      term = term * (-x) / S(n + 3);
    }
  } else {
    shape = S(2) * (x - S(1) + exp(-x)) / (x * x);
  }
  return shape / (S(4) * time_constant_s);
}

/// Volts for a watt of absorbed power, in the steady state.
template <class S>
S bolometer_responsivity_v_w(const ThermalBody<S>& body, const BolometerReadout<S>& readout) {
  const S tcr = mtf::value_of(readout.tcr_per_k) < 0.0 ? S(-readout.tcr_per_k) : readout.tcr_per_k;
  return readout.bias_v * tcr / body.conductance_w_k;
}

/// The terms of the physics. Where 1/f noise has a corner, the lowest frequency has to lie between 0 and the bandwidth.
template <class S>
ThermalNoise<S> bolometer_noise(const ThermalBody<S>& body, const BolometerReadout<S>& readout) {
  using std::log;
  const S volts_per_watt = bolometer_responsivity_v_w(body, readout);
  const S density = S(4 * kBoltzmann_j_k) * body.temperature_k * readout.resistance_ohm;
  ThermalNoise<S> noise;
  noise.fluctuation_w = detail::root(
      S(fluctuation_density_w2_hz(body) * fluctuation_bandwidth_hz(body.time_constant_s(), readout.bandwidth_hz)));
  noise.johnson_w = detail::root(S(density * readout.bandwidth_hz)) / volts_per_watt;
  if (mtf::value_of(readout.corner_hz) > 0.0)
    noise.flicker_w = detail::root(S(density * readout.corner_hz * log(S(readout.bandwidth_hz / readout.lowest_hz)))) /
                      volts_per_watt;
  noise.readout_w = readout.readout_v / volts_per_watt;
  return noise;
}

/// Throws UsageError naming what of the pixel and its readout cannot be: numbers out of their bounds, a conductance
/// below that of radiation, a resistance that does not change with the temperature, 1/f noise without its range.
/// `where` is the table of their keys.
void require_bolometer(const std::string& where, const ThermalBody<double>& body,
                       const BolometerReadout<double>& readout, double emissivity, double area_m2);

}  // namespace radiometry
