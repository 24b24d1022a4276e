// SPDX-License-Identifier: Apache-2.0
#pragma once

// The camera equation: from radiance to electrons in a pixel.
//   irradiance of a lens       E = cone (1 - eta^2) L tau
//   its own emission           cone (1 - eta^2) eps_optics L_bb(T_optics), and of the back of the obscuration,
//                              cone eta^2 eps_obscuration L_bb(T_optics)
//   around the cone of light   (pi - cone) eps_stop L_bb(T_stop), the rest of the hemisphere
//   electrons                  (cold transmission x (lens + its emission) + stop) QE x area x time
//                              + dark current x time
//   volts of a thermal detector  the same with absorptance x area x volts per watt, radiances in watts; less those of
//                              the camera with its shutter closed, which depend on where the shutter stands:
//     between detector and optics  it takes the place of the lens in the cone of light and that of the housing around
//                              it, and its light passes what theirs passes:
//                              cold transmission x cone L_bb(T_shutter) + (pi - cone) L_bb(T_shutter)
//     before the optics        it takes the place of the scene; lens and housing stay, and cancel in the difference:
//                              lens x L_bb(T_shutter) + its emission + stop
// Radiances here are photons per second, m^-2 sr^-1, in the band. eta is the linear obscuration, cone = pi sin^2 theta'
// the projected solid angle of the cone of light at the image, theta' its half angle. What the f-number N says of
// theta' is a choice:
//   tangent  tan theta' = 1/(2 N), cone = pi/(1 + 4 N^2): N is the distance of a flat aperture (cold stop, exit pupil)
//            over its diameter, as a pixel on the axis sees it
//   sine     sin theta' = 1/(2 N), cone = pi/(4 N^2), N >= 0.5: N is the focal length over the entrance pupil of an
//            aplanatic lens (Abbe's sine condition) in air, focused at infinity
// The sine gives 1/(4 N^2) more: 1.6 % at F/4, 6 % at F/2, 25 % at F/1. The tangent is the default: it is how budgets
// of cameras with a cold stop are written (LeMaster and Eismann, Proc. SPIE 10204, 1020405 (2017)), it takes any N, and
// it never gives more than the hemisphere. The obscuration takes eta^2 of either cone: exact for the sine; a flat disc
// in the plane of a flat aperture would take pi eta^2/(4 N^2 + eta^2), which leaves less light than here, by 0.6 % at
// F/2 with eta = 0.3 and by 6 % at F/1 with 0.5. On the axis; cos^4 and vignetting come on top. Templates over the
// scalar S, so that fits and sensitivities differentiate through every number.

#include <limits>

#include "radiometry/fields.h"
#include "radiometry/light/blackbody.h"

namespace radiometry {

/// What the f-number says of the cone of light, see above.
enum class Cone { tangent, sine };
inline constexpr std::array<std::string_view, 2> kConeNames{"tangent", "sine"};
constexpr std::span<const std::string_view> words(Cone) { return kConeNames; }

/// Where the shutter of a thermal camera stands, see above.
enum class ShutterPlace { detector, optics };
inline constexpr std::array<std::string_view, 2> kShutterPlaceNames{"detector", "optics"};
constexpr std::span<const std::string_view> words(ShutterPlace) { return kShutterPlaceNames; }

template <class S>
struct Camera {
  S f_number{};
  S obscuration{};         ///< linear, inner / outer diameter
  S transmission{1};       ///< of the warm optics
  S cold_transmission{1};  ///< of filter and window between cold stop and detector, at its temperature
  S optics_emissivity{};   ///< of the warm optics
  S obscuration_emissivity{};
  S stop_emissivity{1};
  Cone cone = Cone::tangent;
  ShutterPlace shutter_place = ShutterPlace::detector;  ///< of a thermal camera with a shutter

  static constexpr auto fields() {
    return std::tuple{
        required(&Camera::f_number, "f_number", 0.1, 1e4, "2.0", "f-number at the image"),
        below(optional(&Camera::obscuration, "obscuration", 0.0, 1.0, "", "linear obscuration")),
        optional(&Camera::transmission, "transmission", 0.0, 1.0, "", "transmission of the warm optics"),
        optional(&Camera::cold_transmission, "cold_transmission", 0.0, 1.0, "", "transmission of the cold filter"),
        optional(&Camera::optics_emissivity, "optics_emissivity", 0.0, 1.0, "", "emissivity of the warm optics"),
        optional(&Camera::obscuration_emissivity, "obscuration_emissivity", 0.0, 1.0, "",
                 "emissivity of the obscuration"),
        optional(&Camera::stop_emissivity, "stop_emissivity", 0.0, 1.0, "",
                 "emissivity of what surrounds the cone of light")};
  }
};

template <class S>
struct Pixel {
  S width_um{};  ///< of the active area
  S height_um{};
  S quantum_efficiency{1};  ///< electrons per photon, or absorptance
  S integration_s{};
  S dark_e_s{};  ///< dark current, electrons per second
  S full_well_e{std::numeric_limits<double>::infinity()};
  Flux flux = Flux::photons;  ///< what it answers to: watts make it a thermal detector
  S volts_per_watt{};         ///< of a thermal detector, for the power that it absorbs

  bool thermal() const { return flux == Flux::watts; }
  /// Signal for one photon per second, or one watt, that the pixel takes in.
  S signal_per_flux() const { return thermal() ? volts_per_watt : integration_s; }

  S area_m2() const { return width_um * height_um * S(1e-12); }

  static constexpr auto fields() {
    return std::tuple{
        above(required(&Pixel::width_um, "width", "um", 0.0, 1e6, "\"15 um\"", "width of the active area")),
        above(required(&Pixel::height_um, "height", "um", 0.0, 1e6, "\"15 um\"", "height of the active area")),
        optional(&Pixel::quantum_efficiency, "quantum_efficiency", 0.0, 1.0, "0.75", "electrons per photon"),
        above(required(&Pixel::integration_s, "integration_time", "s", 0.0, 1e9, "\"10 ms\"", "integration time")),
        optional(&Pixel::dark_e_s, "dark_current", "e-/s", 0.0, 1e30, "\"1e5 e-/s\"", "dark current"),
        above(required(&Pixel::full_well_e, "full_well", "e-", 0.0, std::numeric_limits<double>::infinity(),
                       "\"1e7 e-\"", "electrons a pixel can hold"))};
  }
};

/// Projected solid angle of the cone of light, sr. Throws UsageError for a sine at an f-number below 0.5.
template <class S>
S cone_sr(const Camera<S>& camera) {
  const S& n = camera.f_number;
  if (camera.cone == Cone::tangent) return S(mtf::kPi) / (S(1) + S(4) * n * n);
  if (!(mtf::value_of(n) >= 0.5))
    throw mtf::UsageError(
        "optics.cone = \"sine\": an f-number of " + mtf::format_double(mtf::value_of(n)) +
        "; sin theta' = 1/(2 N) is at most 1, so N is 0.5 or above: change it, or take cone = \"tangent\"");
  return S(mtf::kPi) / (S(4) * n * n);
}
/// The rest of the hemisphere, pi minus the cone, without cancellation.
template <class S>
S around_cone_sr(const Camera<S>& camera) {
  const S& n = camera.f_number;
  if (camera.cone == Cone::tangent) return cone_sr(camera) * S(4) * n * n;
  return cone_sr(camera) * (S(2) * n - S(1)) * (S(2) * n + S(1));
}

/// Irradiance at the focal plane for a radiance at the aperture: W m^-2, or photons per second and m^2, as the
/// radiance.
template <class S>
S irradiance(const Camera<S>& camera, const S& radiance) {
  return radiance * camera.transmission * camera.cold_transmission * cone_sr(camera) *
         (S(1) - camera.obscuration * camera.obscuration);
}

/// Band radiances in photons, s^-1 m^-2 sr^-1: of the scene and the path at the aperture, of blackbodies at the
/// temperatures of optics and stop. Weighted by what the camera's plain numbers do not hold (band_response.h).
template <class S>
struct BandRadiances {
  S scene{}, path{}, optics{}, stop{};
  /// Of the shutter that a thermal camera takes its offsets from: in the cone of light, weighted by what stands between
  /// shutter and detector; around it, weighted as the stop is.
  S shutter{}, shutter_around{};
};

/// Mean electrons of a pixel by their direction: within the cone of light, which vignetting narrows, and around it.
template <class S>
struct Directions {
  S cone_e{}, around_e{};

  S total_e() const { return cone_e + around_e; }

  bool operator==(const Directions&) const = default;
};

/// Mean electrons in a pixel by where they come from; everything but `scene` is background. Of a thermal detector these
/// are volts, here and wherever a name ends in _e.
template <class S>
struct Signal {
  S scene_e{}, path_e{}, optics_e{}, stop_e{}, dark_e{};
  S shutter_e{};  ///< 0 or less: what the closed shutter gives is taken off

  S total_e() const { return scene_e + path_e + optics_e + stop_e + dark_e + shutter_e; }
};

/// Electrons for one unit of radiance at the aperture: the slope of the signal, e- per (photons s^-1 m^-2 sr^-1), of a
/// thermal detector V per (W m^-2 sr^-1).
template <class S>
S electrons_per_radiance(const Camera<S>& camera, const Pixel<S>& pixel) {
  return irradiance(camera, S(1)) * pixel.quantum_efficiency * pixel.area_m2() * pixel.signal_per_flux();
}

/// Electrons for one unit of radiance and steradian at the detector.
template <class S>
S pixel_gain(const Pixel<S>& pixel) {
  return pixel.quantum_efficiency * pixel.area_m2() * pixel.signal_per_flux();
}

/// What the camera itself sends to a pixel: the emission of its optics, and of the stop around the cone of light.
template <class S>
Directions<S> own_light(const Camera<S>& camera, const Pixel<S>& pixel, const BandRadiances<S>& radiances) {
  const S obscured = camera.obscuration * camera.obscuration;
  const S warm = camera.optics_emissivity * (S(1) - obscured) + camera.obscuration_emissivity * obscured;
  return {pixel_gain(pixel) * camera.cold_transmission * cone_sr(camera) * warm * radiances.optics,
          pixel_gain(pixel) * around_cone_sr(camera) * camera.stop_emissivity * radiances.stop};
}

/// What a pixel of a thermal camera receives while the shutter is closed; nothing without one.
template <class S>
Directions<S> closed_shutter(const Camera<S>& camera, const Pixel<S>& pixel, const BandRadiances<S>& radiances) {
  if (camera.shutter_place == ShutterPlace::optics) {
    const Directions<S> own = own_light(camera, pixel, radiances);
    return {electrons_per_radiance(camera, pixel) * radiances.shutter + own.cone_e, own.around_e};
  }
  return {pixel_gain(pixel) * camera.cold_transmission * cone_sr(camera) * radiances.shutter,
          pixel_gain(pixel) * around_cone_sr(camera) * radiances.shutter_around};
}

template <class S>
Signal<S> signal(const Camera<S>& camera, const Pixel<S>& pixel, const BandRadiances<S>& radiances) {
  const S gain = electrons_per_radiance(camera, pixel);
  const Directions<S> own = own_light(camera, pixel, radiances);
  return {gain * radiances.scene,
          gain * radiances.path,
          own.cone_e,
          own.around_e,
          pixel.dark_e_s * pixel.integration_s,
          -closed_shutter(camera, pixel, radiances).total_e()};
}

/// Part of the full well that is filled; above 1 the pixel saturates.
template <class S>
S well_fill(const Signal<S>& signal, const Pixel<S>& pixel) {
  return signal.total_e() / pixel.full_well_e;
}

/// The integration time in s at which the same flux fills that part of the well.
template <class S>
S integration_for_fill(const Signal<S>& signal, const Pixel<S>& pixel, const S& fill) {
  return pixel.integration_s * fill * pixel.full_well_e / signal.total_e();
}

}  // namespace radiometry
