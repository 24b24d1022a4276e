// SPDX-License-Identifier: Apache-2.0
#pragma once

// The budget of a sensor file in two steps: integrals over the band as plain numbers, then the camera equation and the
// noise in any scalar, so that studies differentiate through it.

#include "radiometry/chain/chain.h"
#include "radiometry/chain/sensor_numbers.h"
#include "radiometry/performance/correction_residual.h"

namespace radiometry {

/// Integrals over the band that a budget takes, all through the camera's curves.
template <class S>
struct SpectralNumbers {
  BandRadiances<S> radiances{};
  S per_k{};                ///< derivative of the scene's radiance by its temperature
  S contrast{};             ///< scene_difference of a target
  S quantum_efficiency{1};  ///< mean_quantum_efficiency
  ThermalReference<S> thermal{};
  S cold_flat{}, hot_flat{};  ///< radiance of the blackbodies of [correction], of a thermal detector

  std::array<S*, 13> all() {
    return {&radiances.scene,          &radiances.path, &radiances.optics, &radiances.stop,     &radiances.shutter,
            &radiances.shutter_around, &per_k,          &contrast,         &quantum_efficiency, &thermal.per_k,
            &thermal.middle,           &cold_flat,      &hot_flat};
  }
};

/// [atmosphere] of the sensor with numbers of it overridden.
AtmosphereSettings atmosphere_with(const Sensor& sensor, const Overrides<double>& numbers);

/// The path of the sensor with numbers of [path] or [atmosphere] overridden. Throws UsageError as Sensor::air.
Path path_with(const Sensor& sensor, const Overrides<double>& numbers);

/// For a surface of that temperature behind the path and a target `warmer_k` above it, with numbers of [scene] and
/// [optics] overridden; overrides that have no part in the integrals are ignored. Throws UsageError as band_radiances.
SpectralNumbers<double> spectral_numbers(const Sensor& sensor, const Path& path, double temperature_k,
                                         double warmer_k = 0.0, const Overrides<double>& numbers = {});

/// The numbers of a sensor behind another path: `own` with radiances.scene, radiances.path and per_k worked out anew.
SpectralNumbers<double> behind_path(SpectralNumbers<double> own, const Sensor& sensor, const Path& path,
                                    double temperature_k, const Overrides<double>& numbers = {});

/// True for a number that only path_with and spectral_numbers read.
bool is_spectral(std::string_view path);
/// True for a number that changes which wavelengths the path lets through, and so how much each counts in the OTF of a
/// band.
bool changes_color(std::string_view path);

/// The part of the variance of a pixel's 1/f noise that the mean of so many successive frames keeps; 0 without it.
double kept_of_flicker(const SensorSettings& settings, int frames);

/// The flat frames of [correction] that a thermal detector takes of two blackbodies, the hot ones right before the
/// cold ones. Their means keep more of its 1/f noise, of that variance, than of white noise, and share some of it.
template <class S>
FlatFrames<S> blackbody_flats(const SensorSettings& settings, const SpectralNumbers<S>& spectral, const S& gain,
                              const Budget<S>& budget, const S& slow_variance, const Overrides<S>& numbers) {
  const Signal<S>& s = budget.signal;
  const S own = s.optics_e + s.stop_e + s.shutter_e;
  const S frame_wide = numbers("noise_3d.t", settings.noise_3d.value_or(Noise3d{}).t);
  const int frames = settings.correction->frames;
  const double one = kept_of_flicker(settings, frames), both = kept_of_flicker(settings, 2 * frames);
  return {.low_e = gain * spectral.cold_flat + own,
          .high_e = gain * spectral.hot_flat + own,
          .full_well_e = S(mtf::kInfinity),
          .variance = budget.floor_e * budget.floor_e - frame_wide * frame_wide + slow_variance * S(frames * one - 1.0),
          .frames = static_cast<double>(frames),
          .shared = slow_variance * S(2.0 * both - one),
          .shot = false};
}

/// The flat frames of [correction]; nothing where the background alone has more electrons than the cold one, so that no
/// scene is dark enough for it. `lost_e`: the part of the background that narcissus takes.
template <class S>
std::optional<FlatFrames<S>> flat_frames(const SensorSettings& settings, const Pixel<S>& pixel,
                                         const Signal<S>& electrons, const S& lost_e, const Budget<S>& budget,
                                         const Overrides<S>& numbers) {
  const CorrectionSettings& correction = *settings.correction;
  const S frame_wide = numbers("noise_3d.t", settings.noise_3d.value_or(Noise3d{}).t);
  const S slow = slow_variance(settings, numbers);
  const int frames = correction.frames;
  const double one = kept_of_flicker(settings, frames), both = kept_of_flicker(settings, 2 * frames);
  const Nonlinearity response = settings.nonlinearity.value_or(Nonlinearity{});
  const S dark_slope = S(1) + Bow<S>(response, pixel.full_well_e, electrons.dark_e).slope;
  FlatFrames<S> flats{.low_e = S(correction.low) * pixel.full_well_e - lost_e,
                      .high_e = S(correction.high) * pixel.full_well_e - lost_e,
                      .dark_e = electrons.dark_e,
                      .full_well_e = pixel.full_well_e,
                      .variance = (budget.floor_e * budget.floor_e - electrons.dark_e) * dark_slope * dark_slope -
                                  frame_wide * frame_wide + slow * S(frames * one - 1.0),
                      .frames = static_cast<double>(frames),
                      .shared = slow * S(2.0 * both - one),
                      .response = response};
  const S background = electrons.optics_e + electrons.stop_e + electrons.dark_e;
  if (mtf::value_of(flats.low_e) < mtf::value_of(background)) return std::nullopt;
  return flats;
}

/// The curve of the absorptance at the reference of the noise; of a photon detector nothing.
ThermalReference<double> thermal_reference(const Sensor& sensor);

/// What vignetting leaves of the light of the lens at the place of that system, 1 on the axis, as vignetting_map() has
/// it. `shares`: of the pixels, where a map or the pupil gives them. Throws UsageError where they do not cover the
/// place, or nothing says how large the detector is.
template <class S>
S light_share(const mtf::System<S>& system, const SensorSettings& settings, const mtf::Image* shares) {
  if (!settings.vignetting || !system.settled) return S(1);
  const Vignetting& corners = *settings.vignetting;
  const mtf::FieldPoint<S>& q = system.point;
  const S r2 = q.x * q.x + q.y * q.y, radius_mm = S(1e-3) * system.field_radius_um();
  if (mtf::value_of(r2) > 0.0 && !(mtf::value_of(radius_mm) > 0.0))
    throw mtf::UsageError("[vignetting]: the light of a place needs the size of the detector; give frame.format");
  S lost(1);
  if (shares != nullptr) {
    const auto at = [](const S& along, const S& radius, const S& pitch, const S& axis, std::int64_t count) {
      const double px = mtf::value_of(S(along * radius / pitch + axis)) + 0.5 * static_cast<double>(count);
      return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(px)), 0, count - 1);
    };
    const S radius_um = system.field_radius_um();
    lost = S(static_cast<double>(
        shares->at(at(q.x, radius_um, system.frame.pitch_x_um, system.field.axis_x_px, shares->width()),
                   at(q.y, radius_um, system.frame.pitch_y_um, system.field.axis_y_px, shares->height()))));
  } else {
    lost = S(1) + r2 * (S(corners.a2) + r2 * (S(corners.a4) + r2 * S(corners.a6)));
    if (mtf::value_of(lost) < 0.0) lost = S(0);
  }
  if (!corners.cos4) return lost;
  const S tangent = radius_mm / system.frame.focal_length_mm;
  return lost * cos4_factor(S(r2 * tangent * tangent));
}

/// The budget, and in it the electrons of the target. Spatial terms are NaN where no flat frame of [correction] can be
/// made, see spatial_gap. Throws UsageError as cone_sr.
template <class S>
Budget<S> sensor_budget(const mtf::System<S>& system, const SensorSettings& settings,
                        const SpectralNumbers<S>& spectral, double flicker_e, const Overrides<S>& numbers = {},
                        const S& light_share = S(1)) {
  Camera<S> camera = camera_numbers(system, settings, numbers);
  camera.transmission = camera.transmission * light_share;  // of light that comes through the lens, not of its own
  Pixel<S> pixel = pixel_numbers(system, settings, numbers, spectral.thermal);
  const S gain = electrons_per_radiance(camera, pixel);
  Signal<S> electrons = signal(camera, pixel, spectral.radiances);
  if (settings.vignetting && pixel.thermal() && settings.thermal->shutter_k &&
      camera.shutter_place == ShutterPlace::detector) {
    // The cone that vignetting narrows shows the housing in its place (glow_of).
    const Directions<S> closed = closed_shutter(camera, pixel, spectral.radiances);
    const S around = (S(mtf::kPi) - light_share * cone_sr(camera)) / around_cone_sr(camera);
    electrons.optics_e = electrons.optics_e * light_share;
    electrons.stop_e = electrons.stop_e * around;
    electrons.shutter_e = S(-1) * (closed.cone_e * light_share + closed.around_e * around);
  }
  // Stray light of a uniform scene, and what it leaves of the contrast of a small target before it (veiling_glare.h).
  const VeilingGlare glare = settings.glare.value_or(VeilingGlare{});
  const double veiled = 1.0 + glare.offset,
               direct = (1.0 - glare.fraction) * (1.0 - settings.ghost.value_or(Ghost{}).fraction);
  electrons.scene_e = electrons.scene_e * S(veiled);
  electrons.path_e = electrons.path_e * S(veiled);
  S lost(0);
  if (settings.narcissus) {
    const S depth = numbers("narcissus.depth", settings.narcissus->depth);
    lost = depth * (electrons.optics_e + electrons.stop_e);
    electrons.optics_e = electrons.optics_e * (S(1) - depth);
    electrons.stop_e = electrons.stop_e * (S(1) - depth);
  }
  const NoiseTerms<S> noise = noise_numbers(settings, pixel, flicker_e, numbers, spectral.thermal);
  const S middle = pixel.quantum_efficiency * spectral.thermal.middle;
  pixel.quantum_efficiency = pixel.quantum_efficiency * spectral.quantum_efficiency;
  Budget<S> budget =
      make_budget(pixel, electrons, noise, S(gain * spectral.per_k * S(direct)),
                  range_numbers(settings, pixel, numbers), settings.nonlinearity.value_or(Nonlinearity{}));
  budget.contrast_e = gain * spectral.contrast * S(direct);
  budget.contrast_share = S(direct / veiled);
  budget.light_share = light_share;
  const S end_e = converter_end_e(settings, pixel, numbers);
  if (!pixel.thermal() && mtf::value_of(end_e) < mtf::value_of(pixel.full_well_e) &&
      !std::isnan(mtf::value_of(budget.dynamic_range)))
    budget.dynamic_range = end_e / budget.floor_e;
  if (pixel.thermal()) budget.nep_w = budget.temporal_e / (pixel.volts_per_watt * middle);
  if (settings.correction && settings.thermal) {
    const S slow = pixel.volts_per_watt * thermal_noise_of(settings, pixel, spectral.thermal, numbers).flicker_w;
    apply_correction(budget, noise.prnu, blackbody_flats(settings, spectral, gain, budget, S(slow * slow), numbers));
  } else if (settings.correction) {
    if (const auto flats = flat_frames(settings, pixel, electrons, lost, budget, numbers)) {
      apply_correction(budget, noise.prnu, *flats);
    } else {
      budget.prnu_e = budget.dsnu_e = budget.correction_e = S(std::numeric_limits<double>::quiet_NaN());
      set_spatial(budget);
    }
  }
  if (settings.correction && budget.saturation.saturated()) {  // the residual is that at a charge of the scene
    refuse_saturated(budget);
    budget.dsnu_e = budget.correction_e = S(std::numeric_limits<double>::quiet_NaN());
  }
  return budget;
}

/// The settings that the budget of a sensor counts: its maps in place of prnu and dsnu, by their standard deviation.
SensorSettings budget_settings(const Sensor& sensor);

/// Sentences that say where simulated frames differ from that budget; none where they agree.
std::vector<std::string> budget_notes(const Sensor& sensor, const Budget<double>& budget);

/// Why the spatial terms of that budget have no number, "" where they have.
template <class S>
std::string spatial_gap(const SensorSettings& settings, const Budget<S>& budget) {
  if (!settings.correction || budget.saturation.saturated() || !std::isnan(mtf::value_of(budget.spatial_e))) return "";
  const Signal<S>& electrons = budget.signal;
  return "[correction]: no flat frame at " + mtf::format_double(settings.correction->low) +
         " of full well can be made: the background alone has " +
         mtf::format_double(std::round(mtf::value_of(S(electrons.optics_e + electrons.stop_e + electrons.dark_e)))) +
         " e-; raise correction.low, or shorten the integration time";
}

}  // namespace radiometry
