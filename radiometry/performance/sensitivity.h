// SPDX-License-Identifier: Apache-2.0
#pragma once

// Noise of a pixel and the figures of its sensitivity, in closed form. Temporal terms, electrons rms:
//   shot       sqrt(electrons), of scene and path, of the background (optics, stop), of the dark current
//   read, kTC  as given; kTC = sqrt(k T C) / q for a capacitance that is reset
//   quantisation   rounding to counts of one step: step / sqrt(12) where the noise before it dithers (0.4 steps),
//                  below, the mean over all signals (RoundingNoise), and the rest of step^2 / 12 is spatial
// Spatial terms: responsivity (PRNU x electrons of light), offset and dark charge (DSNU and DCNU), both after
// correction (correction_residual.h says what a two-point correction leaves), the noise of the flat frames that it was
// made from, and the error of rounding that no noise dithers.
// All noise counts as charge. Where the response R of a pixel is not linear (nonlinearity.h), what comes behind it, all
// but shot noise, PRNU and DCNU, is divided by its slope R'(e) at the charge of the scene, in the floor at the dark
// charge.
//   NETD  temporal noise / (d electrons / dT)
//   NEI   noise / (QE A t), photons s^-1 m^-2 at the detector, of the spectrum that the scene has there; QE the mean
//         over those photons
//   D*    sqrt(A df) / NEP, df = 1/(2 t), NEP = noise h c / (lambda QE t), at one wavelength: QE there
//   NETD from D* = sqrt(df) / (cone tau sqrt(A) integral of D* dL/dT dlambda), cone as in signal.h
// (Lloyd, Thermal Imaging Systems, ch. 5, with pi/(4 N^2) for the cone.)
// A pixel or converter that is full (saturation.h) gives the same value whatever the scene: slope, noise of light and
// dark current and every figure made of them are NaN then, the electrons by source and the noise of the readout stay.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "mtf/component.h"
#include "radiometry/light/constants.h"
#include "radiometry/light/signal.h"
#include "radiometry/stages/detector/nonlinearity.h"
#include "radiometry/stages/detector/saturation.h"

namespace radiometry {

// The noise of rounding to whole steps behind Gaussian noise of s steps rms, as the mean over all places of the signal
// between two steps. With y = round(m + s n), V(m) and b(m) the variance and the bias of y at the signal m:
//   mean of b^2 = B(s) = sum over k >= 1 of exp(-4 pi^2 k^2 s^2)/(2 pi^2 k^2),  1/12 at s = 0, 9e-5 at s = 0.4
//   mean of V   = s^2 + 1/12 - B,  s/sqrt(pi) below s = 0.05
//   dE[y]/dm    = 1 + 2 sum of (-1)^k cos(2 pi k m) exp(-2 pi^2 k^2 s^2): 1 in the mean, least in the middle of a step
// The mean square of y - m is s^2 + 1/12 at any s; what of it does not change from frame to frame is an error that
// stays. Sheppard's 1/12 is a temporal noise where s dithers, from some 0.4 on. Below, most signals give one count
// without noise, and a change of the signal by less than a step may change nothing.
// (Widrow and Kollar, Quantization Noise, Cambridge 2008, chs. 4 and 19.)

/// Values in steps^2, slopes by s.
struct RoundingNoise {
  mtf::ValueSlope temporal;  ///< mean of V less s^2: what rounding adds to the noise from frame to frame
  mtf::ValueSlope fixed;     ///< B: of the error that stays
  double response = 1.0;     ///< least dE[y]/dm, 0 to 1: a small change shows as that part of itself at some signals
};

/// `noise_steps`: s, 0 or above.
RoundingNoise rounding_noise(double noise_steps);

/// s of the whole temporal noise s^2 + 1/12 - B (its square, in steps^2, 0 or above), the inverse of the above.
mtf::ValueSlope noise_before_rounding(double temporal_steps2);

/// The least response from which on noise counts as dithering: s = 0.39.
inline constexpr double kDitheredResponse = 0.9;

/// Noise sources beside shot noise, rms electrons but for prnu.
template <class S>
struct NoiseTerms {
  S read_e{};
  S reset_e{};  ///< kTC
  S other_e{};  ///< further temporal noise
  S step_e{};   ///< electrons per count of the ADC; 0: no quantisation
  S prnu{};     ///< residual, fraction of the electrons of light
  S dsnu_e{};   ///< residual offset
  S dcnu_e{};   ///< spread of the dark charge from pixel to pixel, which fills the well as light does

  static constexpr auto fields() {
    constexpr auto electrons = [](auto member, std::string_view name, std::string_view doc) {
      return optional(member, name, "e-", 0.0, 1e15, "\"30 e-\"", doc);
    };
    return std::tuple{
        electrons(&NoiseTerms::read_e, "read", "read noise, rms"),
        electrons(&NoiseTerms::reset_e, "reset", "kTC noise, rms"),
        electrons(&NoiseTerms::other_e, "other", "further temporal noise, rms"),
        electrons(&NoiseTerms::step_e, "step", "electrons per count"),
        optional(&NoiseTerms::prnu, "prnu", 0.0, 1.0, "0.01", "responsivity non-uniformity, rms fraction"),
        electrons(&NoiseTerms::dsnu_e, "dsnu", "offset non-uniformity, rms"),
        electrons(&NoiseTerms::dcnu_e, "dcnu", "dark-current non-uniformity, rms")};
  }
};

namespace detail {
template <class S>
S root(const S& x) {
  using std::sqrt;
  return mtf::value_of(x) <= 0.0 ? S(0) : S(sqrt(x));  // NaN stays NaN
}
}  // namespace detail

/// sqrt(k T C) / q: rms electrons on a capacitance in farad at a temperature in K.
template <class S>
S reset_noise_e(const S& capacitance_f, const S& temperature_k) {
  return detail::root(S(kBoltzmann_j_k * temperature_k * capacitance_f)) / S(kElementaryCharge_c);
}

/// The capacitance that is reset, for the kTC noise of NoiseTerms::reset_e.
struct ResetNoise {
  double capacitance_f = 0.0;
  double temperature_k = 0.0;

  double rms_e() const { return reset_noise_e(capacitance_f, temperature_k); }

  static constexpr auto fields() {
    return std::tuple{required(&ResetNoise::capacitance_f, "capacitance", "F", 0.0, 1e6, "\"50 fF\"",
                               "capacitance that is reset before each integration"),
                      required(&ResetNoise::temperature_k, "temperature", "K", 0.0, 1e6, "\"77 K\"",
                               "temperature of the circuit that resets it")};
  }
};

/// How far the noise before the converter dithers its rounding.
struct Dither {
  double noise_steps = mtf::kInfinity;  ///< counts rms before the rounding; infinite without a converter
  double response = 1.0;                ///< RoundingNoise::response
  double step_k = 0.0;                  ///< one count as a temperature difference of the scene

  bool dithered() const { return response >= kDitheredResponse; }
};
/// Which differences of the scene the frames may not show, and what that makes of the figures; "" where noise dithers.
std::string words(const Dither& dither);

/// Every term of signal and noise, and the figures they give.
template <class S>
struct Budget {
  Signal<S> signal;
  S well_fill{};
  S signal_per_k{};     ///< d electrons / dT
  S slope{1};           ///< of the response at this charge, by which noise behind it has been divided
  S contrast_e{};       ///< electrons that a target has more than the scene, where one is given (sensor_budget.h)
  S contrast_share{1};  ///< of the scene's electrons, what stray light leaves of a small target's contrast
  S light_share{1};     ///< what vignetting leaves of the light of a scene
  S full_well_e{};
  Nonlinearity response{};
  PixelRange range{};  ///< of the converter
  // Temporal noise, e- rms.
  S scene_shot_e{}, background_shot_e{}, dark_shot_e{}, read_e{}, reset_e{}, other_e{}, quantisation_e{};
  S temporal_e{};  ///< their root sum of squares
  S floor_e{};     ///< without light: dark, read, reset, other and all of the rounding, whose error is noise or stays
  // Spatial noise, e- rms.
  S prnu_e{}, dsnu_e{}, correction_e{}, rounding_e{}, spatial_e{};
  // Of both sums, what comes behind [[readout]], which does not filter it: all but shot noise, PRNU and dark charge.
  S late_temporal_e{}, late_spatial_e{};
  S dcnu_e{};  ///< the part of dsnu_e that is charge, before any correction
  // Figures.
  S snr{};             ///< electrons of the scene / temporal noise
  S shot_netd_k{};     ///< from the shot noise of all light alone
  S netd_k{};          ///< from the temporal noise
  S spatial_netd_k{};  ///< from the spatial noise
  S nei_ph{};          ///< photons s^-1 m^-2 at the detector; W m^-2 of a thermal one
  S nep_w{};           ///< of a thermal detector: incident power that equals the temporal noise
  S dynamic_range{};   ///< full well / floor, or the end of the converter where that comes first (sensor_budget.h)
  Saturation saturation{};
  Dither dither{};
};

/// spatial_e and spatial_netd_k from the spatial terms.
template <class S>
void set_spatial(Budget<S>& b) {
  b.spatial_e = detail::root(
      S(b.prnu_e * b.prnu_e + b.dsnu_e * b.dsnu_e + b.correction_e * b.correction_e + b.rounding_e * b.rounding_e));
  b.spatial_netd_k = b.spatial_e / b.signal_per_k;
}

/// Makes NaN of the figures that a saturated budget has no number for.
template <class S>
void refuse_saturated(Budget<S>& b) {
  const S none(std::numeric_limits<double>::quiet_NaN());
  for (S Budget<S>::*figure :
       {&Budget<S>::signal_per_k, &Budget<S>::scene_shot_e, &Budget<S>::background_shot_e, &Budget<S>::dark_shot_e,
        &Budget<S>::temporal_e, &Budget<S>::prnu_e, &Budget<S>::spatial_e, &Budget<S>::snr, &Budget<S>::shot_netd_k,
        &Budget<S>::netd_k, &Budget<S>::spatial_netd_k, &Budget<S>::nei_ph, &Budget<S>::nep_w})
    b.*figure = none;
  if (b.dither.noise_steps < mtf::kInfinity) b.quantisation_e = b.rounding_e = none;
  // The dark current alone may saturate the pixel.
  const Saturation& s = b.saturation;
  if (s.end != RangeEnd::least_count && mtf::value_of(b.signal.dark_e) >= s.end_e) b.floor_e = b.dynamic_range = none;
}

/// What ends the values of a target with so many more electrons than the scene.
template <class S>
Saturation target_saturation(const Budget<S>& b, const S& more_e) {
  const double more = mtf::value_of(more_e), more2 = b.saturation.volts ? 0.0 : std::max(more, 0.0);
  const double shot_e = std::hypot(mtf::value_of(b.scene_shot_e), mtf::value_of(b.background_shot_e),
                                   std::hypot(mtf::value_of(b.dark_shot_e), std::sqrt(more2)));
  Saturation s = saturation_of({.mean_e = mtf::value_of(b.signal.total_e()) + more,
                                .well_e = shot_e,
                                .converter_e = std::hypot(mtf::value_of(b.temporal_e), std::sqrt(more2))},
                               b.range, mtf::value_of(b.full_well_e));
  s.volts = b.saturation.volts;
  return s;
}

/// What frames show of so many more electrons than the scene's: (R(e + more) - R(e)) / R'(e), charge as all the rest.
template <class S>
S seen_difference(const Budget<S>& b, const S& more_e) {
  const S scene_e = b.signal.total_e();
  const Bow<S> here(b.response, b.full_well_e, scene_e), there(b.response, b.full_well_e, S(scene_e + more_e));
  return (more_e + there.value - here.value) / b.slope;
}

/// How the values of all pixels and frames scatter in the well and before the converter (which adds its rounding). The
/// spatial terms of the budget have to be those before any correction.
template <class S>
PixelScatter scatter_of(const Budget<S>& b, bool shot) {
  const double total_e = mtf::value_of(b.signal.total_e());
  const double shot_e = shot ? std::sqrt(std::max(total_e, 0.0)) : 0.0;
  const double readout_e = std::hypot(mtf::value_of(b.read_e), mtf::value_of(b.reset_e), mtf::value_of(b.other_e));
  const double light_e = std::hypot(shot_e, mtf::value_of(b.prnu_e));
  return {.mean_e = total_e,
          .well_e = std::hypot(light_e, mtf::value_of(b.dcnu_e)),
          .converter_e = std::hypot(light_e, readout_e, mtf::value_of(b.dsnu_e))};
}

/// `signal_per_k` in electrons per K: electrons_per_radiance x scene_derivative, or a difference of signals.
/// `pixel.quantum_efficiency`: the whole one, with mean_quantum_efficiency where curves have a part in it. `range`: of
/// the converter, where there is one. `response`: of the pixel, with a finite full well.
template <class S>
Budget<S> make_budget(const Pixel<S>& pixel, const Signal<S>& signal, const NoiseTerms<S>& noise, const S& signal_per_k,
                      const PixelRange& range = {}, const Nonlinearity& response = {}) {
  using detail::root;
  Budget<S> b;
  b.signal = signal;
  b.full_well_e = pixel.full_well_e;
  b.response = response;
  b.range = range;
  b.well_fill = radiometry::well_fill(signal, pixel);
  b.signal_per_k = signal_per_k;
  const S scene = signal.scene_e + signal.path_e, background = signal.optics_e + signal.stop_e + signal.shutter_e;
  // Variance of the signal for one unit of it: electrons have shot noise. The volts of a thermal detector have none
  // beside their read noise, in which the fluctuation of the light is counted.
  const S shot(pixel.thermal() ? 0.0 : 1.0);
  b.scene_shot_e = root(S(shot * scene));
  b.background_shot_e = root(S(shot * background));
  b.dark_shot_e = root(S(shot * signal.dark_e));
  const auto slope_at = [&](const S& charge_e) { return S(1) + Bow<S>(response, pixel.full_well_e, charge_e).slope; };
  b.slope = slope_at(signal.total_e());
  b.read_e = noise.read_e / b.slope;
  b.reset_e = noise.reset_e / b.slope;
  b.other_e = noise.other_e / b.slope;
  const S behind2 = noise.read_e * noise.read_e + noise.reset_e * noise.reset_e + noise.other_e * noise.other_e,
          readout2 = behind2 / (b.slope * b.slope), step_e = noise.step_e / b.slope, at_dark = slope_at(signal.dark_e);
  b.floor_e = root(S(shot * signal.dark_e + (behind2 + noise.step_e * noise.step_e / S(12)) / (at_dark * at_dark)));
  const S before2 = shot * (scene + background + signal.dark_e) + readout2;
  if (mtf::value_of(step_e) > 0.0) {
    const S steps = root(before2) / step_e;
    const RoundingNoise rounding = rounding_noise(mtf::value_of(steps));
    b.quantisation_e = step_e * root(mtf::lift(rounding.temporal, steps));
    b.rounding_e = step_e * root(mtf::lift(rounding.fixed, steps));
    b.dither = {mtf::value_of(steps), rounding.response, mtf::value_of(step_e) / mtf::value_of(signal_per_k)};
  }
  b.temporal_e = root(S(before2 + b.quantisation_e * b.quantisation_e));
  b.late_temporal_e = root(S(readout2 + b.quantisation_e * b.quantisation_e));
  const S light = scene + background;  // below 0 where a scene is colder than the shutter of a thermal detector
  b.prnu_e = noise.prnu * (mtf::value_of(light) < 0.0 ? S(-light) : light);
  b.dcnu_e = noise.dcnu_e;
  const S offset_e = noise.dsnu_e / b.slope;
  b.dsnu_e = root(S(offset_e * offset_e + noise.dcnu_e * noise.dcnu_e));
  b.late_spatial_e = root(S(offset_e * offset_e + b.rounding_e * b.rounding_e));
  b.snr = signal.scene_e / b.temporal_e;
  b.shot_netd_k = root(S(shot * (scene + background))) / signal_per_k;
  b.netd_k = b.temporal_e / signal_per_k;
  set_spatial(b);
  b.nei_ph = b.temporal_e / (pixel.quantum_efficiency * pixel.area_m2() * pixel.signal_per_flux());
  b.dynamic_range = pixel.full_well_e / b.floor_e;
  b.saturation = saturation_of(scatter_of(b, !pixel.thermal()), range, mtf::value_of(pixel.full_well_e));
  b.saturation.volts = pixel.thermal();
  if (b.saturation.saturated()) refuse_saturated(b);
  return b;
}

enum class BudgetGroup { signal, temporal, spatial, sensitivity };

/// One line of a printed budget.
struct BudgetRow {
  std::string name, unit;
  double value = 0.0;
  std::string doc;
  std::string refused{};   ///< why there is no value, "" where there is one
  bool saturated = false;  ///< no value since the pixel or the converter is full
  BudgetGroup group = BudgetGroup::sensitivity;
  bool term = false;  ///< of noise: the squares of the terms of a group add up to its variance
};
/// Adds rows to a group, all of them its terms or none.
void add_rows(std::vector<BudgetRow>& all, BudgetGroup group, std::vector<BudgetRow> rows, bool terms = false);
/// The spatial noise of a budget, its terms and their sum. `dsnu`: what its row holds.
void add_spatial_rows(std::vector<BudgetRow>& all, const Budget<double>& budget, const std::string& unit,
                      const std::string& dsnu);
/// True for a figure of that budget without a value since the pixel or the converter is full.
bool is_saturated(const Budget<double>& budget, double value);
/// Why a figure of that budget has no finite value, "" where it has one.
std::string refusal_of(const Budget<double>& budget, double value);
/// All of the budget in the order of the physics; the NETDs in mK, the dynamic range in dB.
std::vector<BudgetRow> rows(const Budget<double>& budget);

/// D* in cm sqrt(Hz) / W at a wavelength, of a pixel with that temporal noise.
template <class S>
S dstar_jones(const Pixel<S>& pixel, const S& noise_e, const S& wavelength_um) {
  const S area_cm2 = pixel.area_m2() * S(1e4);
  const S electrons_per_joule = pixel.quantum_efficiency * wavelength_um / S(kPhotonEnergy_j_um);
  return electrons_per_joule * detail::root(S(area_cm2 * pixel.integration_s * S(0.5))) / noise_e;
}

/// NETD in K from D*: `weighted` is the integral of D* dL/dT over the band, in cm sqrt(Hz) W^-1 x W m^-2 sr^-1 K^-1.
template <class S>
S netd_from_dstar_k(const Camera<S>& camera, const Pixel<S>& pixel, const S& weighted) {
  const S bandwidth_hz = S(0.5) / pixel.integration_s;
  const S per_metre = weighted * S(1e-2);  // D* in m sqrt(Hz) / W
  return detail::root(bandwidth_hz) / (irradiance(camera, per_metre) * detail::root(pixel.area_m2()));
}

}  // namespace radiometry
