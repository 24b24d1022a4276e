// SPDX-License-Identifier: Apache-2.0
#pragma once

// [detector] kind = "thermal": microbolometer, thermopile, pyroelectric (performance/thermal_detector.h has the
// physics). Its noise is given once, in one of four forms:
//   NETD     netd with netd_f_number, netd_transmission and netd_temperature: of a blackbody, through optics that let
//            that part of its light pass, in [band] or from netd_shortest to netd_longest. The cone of light is that of
//            [optics] cone, as for the camera itself. netd_of = "focal_plane" is the detector alone, "camera" has
//            readout and converter in it
//   NEP      nep in nep_bandwidth, or nep_density per root hertz
//   D*       dstar
//   physics  heat_capacity, conductance, temperature, resistance, tcr, bias; 1/f noise by corner and lowest_frequency
// NEP, D* and responsivity are those of incident power at the middle of [band], as data sheets have them: the power
// that the pixel absorbs is absorptance times that.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "radiometry/fields.h"
#include "radiometry/light/signal.h"
#include "radiometry/light/spectral_signal.h"

namespace radiometry {

enum class DetectorKind { photon, thermal };
inline constexpr std::array<std::string_view, 2> kDetectorKindNames{"photon", "thermal"};
constexpr std::span<const std::string_view> words(DetectorKind) { return kDetectorKindNames; }

/// What an NETD that is given has in it.
enum class NetdOf { focal_plane, camera };
inline constexpr std::array<std::string_view, 2> kNetdOfNames{"focal_plane", "camera"};
constexpr std::span<const std::string_view> words(NetdOf) { return kNetdOfNames; }

struct ThermalSettings {
  DetectorKind kind = DetectorKind::thermal;
  std::optional<double> width_um{}, height_um{};  ///< of the active area; neither: the pitch
  std::optional<double> fill_factor{};            ///< in place of both: active area / pitch^2
  NumberOrFile absorptance{1.0};
  std::optional<double> responsivity_v_w{};
  std::optional<double>
      counts_per_k{};  ///< at the reference of the NETD, in place of responsivity and volts of a count
  std::optional<double> shutter_k{};
  ShutterPlace shutter_place = ShutterPlace::detector;
  double drift_k_s = 0.0;                      ///< of shutter, housing and optics
  std::optional<double> shutter_interval_s{};  ///< from one offset to the next
  int shutter_frames = 0;                      ///< the same in frames; 0: not given
  std::optional<double> bandwidth_hz{};
  double readout_v = 0.0;
  std::optional<double> netd_k{}, netd_f_number{}, netd_transmission{}, netd_temperature_k{}, netd_bandwidth_hz{};
  std::optional<double> netd_frame_rate_hz{};  ///< in place of both bandwidths (sensor_settings.cpp)
  std::optional<double> netd_shortest_um{}, netd_longest_um{};
  NetdOf netd_of = NetdOf::focal_plane;
  std::optional<double> nep_w{}, nep_bandwidth_hz{}, nep_density{};
  std::optional<double> dstar_jones{};
  std::optional<double> heat_capacity_j_k{}, conductance_w_k{}, temperature_k{};
  std::optional<double> resistance_ohm{}, tcr_per_k{}, bias_v{};
  std::optional<double> corner_hz{}, lowest_hz{};

  /// True where the noise is that of the physics: any of its keys is given.
  bool physics() const {
    return heat_capacity_j_k || conductance_w_k || temperature_k || resistance_ohm || tcr_per_k || bias_v ||
           corner_hz || lowest_hz;
  }

  /// True where the shutter closes now and then; else every frame has an offset of its own.
  bool closes() const { return shutter_interval_s || shutter_frames > 0; }

  static constexpr auto fields() {
    using T = ThermalSettings;
    return std::tuple{
        optional(&T::kind, "kind", "\"thermal\"", "photon: electrons; thermal: a pixel that warms"),
        optional(&T::width_um, "width", "um", 1e-3, 1e6, "\"15 um\"",
                 "of the active area, alone that of a square; else the pitch"),
        optional(&T::height_um, "height", "um", 1e-3, 1e6, "\"15 um\"",
                 "of the active area; with width alone the same, with neither the pitch"),
        optional(&T::fill_factor, "fill_factor", 1e-6, 1.0, "0.9",
                 "active area over that of the pitch, in place of both"),
        optional(&T::absorptance, "absorptance", 0.0, 1.0, "0.8",
                 "part of the incident power that is absorbed: a number or the CSV file of a curve"),
        optional(&T::responsivity_v_w, "responsivity", 1e-30, 1e30, "1e5",
                 "V/W of incident power at the middle of the band; not with the physics, which gives it"),
        optional(
            &T::counts_per_k, "counts_per_kelvin", 1e-30, 1e30, "30.0",
            "counts of [adc] for a kelvin at the reference of the NETD, in place of responsivity and volts_per_count"),
        optional(&T::shutter_k, "shutter_temperature", "K", 0.0, 1e6, "\"300 K\"",
                 "of the shutter that offsets are taken from: the signal is the difference to it"),
        optional(&T::shutter_place, "shutter_place", "\"optics\"",
                 "between detector and optics (detector), or before the optics (optics)"),
        optional(&T::drift_k_s, "shutter_drift", -10.0, 10.0, "0.01",
                 "K/s by which shutter, housing and optics get warmer, from frame 0 on"),
        optional(&T::shutter_interval_s, "shutter_interval", "s", 1e-12, 1e12, "\"60 s\"",
                 "from one closing of the shutter, which gives a new offset, to the next; else every frame has an "
                 "offset of its own"),
        optional(&T::shutter_frames, "shutter_frames", 0.0, 1e9, "1800", "the same interval in frames"),
        optional(&T::bandwidth_hz, "noise_bandwidth", "Hz", 1e-12, 1e15, "\"30 Hz\"", "of the readout"),
        optional(&T::readout_v, "readout_noise", "V", 0.0, 1e6, "\"10 uV\"",
                 "rms, of what follows the detector; not beside an NETD of the camera"),
        optional(&T::netd_k, "netd", mtf::Dimension::temperature_difference, "K", 1e-12, 1e6, "\"50 mK\"",
                 "noise-equivalent temperature difference at its reference"),
        optional(&T::netd_f_number, "netd_f_number", 0.1, 1e4, "1.0", "f-number at which the NETD holds"),
        optional(&T::netd_transmission, "netd_transmission", 1e-6, 1.0, "1.0", "of the optics at which the NETD holds"),
        optional(&T::netd_temperature_k, "netd_temperature", "K", 1.0, 1e6, "\"300 K\"",
                 "of the scene at which the NETD holds"),
        optional(&T::netd_bandwidth_hz, "netd_bandwidth", "Hz", 1e-12, 1e15, "\"30 Hz\"",
                 "noise bandwidth of the NETD; else that of this camera"),
        optional(&T::netd_frame_rate_hz, "netd_frame_rate", "Hz", 1e-12, 1e15, "\"30 Hz\"",
                 "frame rate at which the NETD was measured, in place of both bandwidths: noise follows the root of "
                 "the frame rate, which is 1/frame_time for this camera"),
        optional(&T::netd_shortest_um, "netd_shortest", "um", 0.1, 1e4, "\"8 um\"",
                 "wavelength at which the band of the NETD begins; else it is [band]"),
        optional(&T::netd_longest_um, "netd_longest", "um", 0.1, 1e4, "\"14 um\"",
                 "wavelength at which the band of the NETD ends"),
        optional(&T::netd_of, "netd_of", "\"camera\"",
                 "focal_plane: the detector alone; camera: with its readout noise and converter, without what "
                 "[flicker], [noise] and [noise_3d] add"),
        optional(&T::nep_w, "nep", "W", 1e-30, 1e6, "\"10 pW\"",
                 "incident power that equals the noise in nep_bandwidth"),
        optional(&T::nep_bandwidth_hz, "nep_bandwidth", "Hz", 1e-12, 1e15, "\"30 Hz\"",
                 "noise bandwidth of nep; else that of this camera"),
        optional(&T::nep_density, "nep_density", 1e-30, 1e6, "2e-12", "incident power, W Hz^-1/2, in noise_bandwidth"),
        optional(&T::dstar_jones, "dstar", 1e-6, 1e30, "1e9", "cm Hz^1/2 W^-1 of incident power, in noise_bandwidth"),
        optional(&T::heat_capacity_j_k, "heat_capacity", 0.0, 1.0, "3e-10", "J/K of a pixel"),
        optional(&T::conductance_w_k, "conductance", 0.0, 1.0, "3e-8",
                 "W/K from a pixel to its surroundings; heat_capacity over it is the time constant"),
        optional(&T::temperature_k, "temperature", "K", 1.0, 1e4, "\"300 K\"", "of the pixels"),
        optional(&T::resistance_ohm, "resistance", 1e-12, 1e12, "1e5", "ohm, of a pixel"),
        optional(&T::tcr_per_k, "tcr", -10.0, 10.0, "-0.02", "temperature coefficient of the resistance, 1/K"),
        optional(&T::bias_v, "bias", "V", 1e-12, 1e6, "\"2 V\"", "across a pixel while it is read"),
        optional(&T::corner_hz, "corner", "Hz", 1e-12, 1e15, "\"500 Hz\"",
                 "frequency at which 1/f noise equals Johnson noise; without it there is none"),
        optional(&T::lowest_hz, "lowest_frequency", "Hz", 1e-12, 1e15, "\"0.01 Hz\"",
                 "of 1/f noise: the inverse of the time between two corrections of the offset")};
  }
};

/// Throws UsageError, beginning with the key, for noise that is given in no form or in two, without its reference or
/// bandwidth, for a missing responsivity, and as require_bolometer. `middle_absorptance`: at the middle of the band.
void require_thermal(const ThermalSettings& settings, double area_m2, double middle_absorptance);

/// What to say of an NETD, a NEP or a D* that is taken to a noise bandwidth more than ten times 1/(4 tau), or from one:
/// the root of the bandwidths holds for white noise, and the temperature fluctuation of a pixel is white up to
/// 1/(2 pi tau) alone (thermal_detector.h). "" where there is nothing to say.
std::string bandwidth_warning(const ThermalSettings& settings, double time_constant_s);

// The shutter of a thermal camera over a sequence. It closes at frame 0 and in regular intervals after it; what the
// pixels give then is taken off the frames up to the next closing. Between two closings the camera gets warmer at a
// constant rate, and shutter, housing and optics with it:
//   T(n) = T(0) + drift n T_frame                      of frame n
//   frame n = open camera at T(n) - closed camera at T(m),   m = the last closing, at frame n or before it
// So frames between closings have a false offset: the housing and the optics have warmed since the last closing. The
// next one removes it. The shutter itself has warmed too, and the signal is the difference to the shutter: after a
// closing the same scene gives less. (Nugent, Shaw and Pust, Opt. Eng. 52, 061304 (2013): drift of microbolometer
// cameras with their temperature. Signals of the open and the closed camera: light/signal.h.)

struct ShutterEvents {
  double drift_k_s = 0.0;
  double frame_time_s = 0.0;
  std::uint32_t interval = 1;  ///< frames from one closing to the next

  std::uint32_t closing_before(std::uint32_t frame) const { return frame - frame % interval; }
  double warming_k(std::uint32_t frame) const { return drift_k_s * frame_time_s * frame; }
};

/// Frames in an interval, at least one.
inline std::uint32_t interval_frames(double interval_s, double frame_time_s) {
  return static_cast<std::uint32_t>(std::clamp(std::round(interval_s / frame_time_s), 1.0, 1e9));
}

/// A camera that is so much warmer: all of it that emits at all.
inline CameraEmission warmed(CameraEmission camera, double by_k) {
  for (double* temperature_k : {&camera.optics_k, &camera.stop_k, &camera.shutter_k})
    if (*temperature_k > 0.0) *temperature_k = std::max(*temperature_k + by_k, 0.0);
  return camera;
}

/// The last closing that a frame of a sequence knows of.
struct ShutterClosing {
  std::uint32_t frame = 0;
  CameraEmission camera;
};

}  // namespace radiometry
