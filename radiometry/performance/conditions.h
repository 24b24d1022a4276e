// SPDX-License-Identifier: Apache-2.0
#pragma once

// What figures of image quality and acquisition take from outside of the sensor: target, scene, observer, geometry.
// [conditions] of a study.
//
// The observer sees the picture of the whole format on a display of height h at the distance d:
//   magnification   angle at the eye / angle in object space = (h/d) / (rows x pitch_y / focal length), on the axis
//   size of the picture at the eye   2 atan(h/(2 d)), and so for its width; the root of their product
// A magnification may be given in place of the display; the picture then has the usual 10 degrees of contrast
// sensitivities.

#include <array>
#include <optional>

#include "mtf/components/eye_fits.h"
#include "mtf/frame.h"
#include "radiometry/fields.h"

namespace radiometry {

struct Conditions {
  double temperature_k = 300.0;
  std::optional<double> range_m{};  ///< without it that of the sensor's air, where this has one
  double elevation_deg = 90.0;
  std::optional<double> contrast_k{}, target_size_m{}, signal_contrast{};
  std::optional<double> extinction_per_km{};
  double scene_contrast_k = 5.0, snr_threshold = 2.5, eye_time_s = 0.1;
  std::optional<double> frame_rate_hz{};  ///< else 1 / frame time
  double luminance_cd_m2 = 34.26;
  std::optional<double> magnification{}, display_height_m{}, viewing_distance_m{};
  double v50_detect = 2.0, v50_recognise = 7.5, v50_identify = 13.0;
  double probability = 0.5;  ///< of the tasks at their ranges

  static constexpr auto fields() {
    using C = Conditions;
    return std::tuple{
        above(optional(&C::temperature_k, "temperature", "K", 0.0, 1e5, "\"300 K\"",
                       "of the surface that the pixel images")),
        above(optional(&C::range_m, "range", "m", 0.0, 1e13, "\"5 km\"",
                       "to the target along the line of sight, for GSD and all that follows from it")),
        above(optional(&C::elevation_deg, "elevation", "deg", 0.0, 90.0, "\"60 deg\"",
                       "of the sensor seen from the target")),
        above(optional(&C::contrast_k, "contrast", mtf::Dimension::temperature_difference, "K", 0.0, 1e5, "\"2 K\"",
                       "of the target to its background")),
        above(
            optional(&C::target_size_m, "target_size", "m", 0.0, 1e6, "\"3.1 m\"", "square root of the target's area")),
        above(optional(&C::signal_contrast, "signal_contrast", 0.0, 1.0, "0.5",
                       "(bright - dark)/bright of two reflecting surfaces")),
        optional(&C::extinction_per_km, "extinction", 0.0, 1e6, "0.2",
                 "of the apparent contrast with range, per km, for sensor files without air of their own"),
        above(optional(&C::scene_contrast_k, "scene_contrast", mtf::Dimension::temperature_difference, "K", 0.0, 1e5,
                       "\"5 K\"", "apparent, from dark to mean luminance of the display")),
        above(optional(&C::snr_threshold, "snr_threshold", 0.0, 1e3, "2.5",
                       "that the observer of bars and squares needs")),
        above(optional(&C::eye_time_s, "eye_time", "s", 0.0, 1e3, "\"0.1 s\"", "integration of the eye")),
        above(optional(&C::frame_rate_hz, "frame_rate", "Hz", 0.0, 1e9, "\"60 Hz\"", "else 1 / frame time")),
        optional(&C::luminance_cd_m2, "luminance", "cd/m^2", mtf::kLuminanceLo, mtf::kLuminanceHi, "\"34 cd/m^2\"",
                 "mean of the display"),
        optional(&C::magnification, "magnification", 1e-3, 1e6, "5.0",
                 "angle at the eye / angle in object space, in place of the display"),
        above(optional(&C::display_height_m, "display_height", "m", 0.0, 1e3, "\"200 mm\"",
                       "of the picture of the whole format")),
        above(optional(&C::viewing_distance_m, "viewing_distance", "m", 0.0, 1e3, "\"600 mm\"",
                       "from the eye to the display")),
        above(optional(&C::v50_detect, "v50_detect", 0.0, 1e6, "2.0", "cycles on target that half of the trials need")),
        above(optional(&C::v50_recognise, "v50_recognise", 0.0, 1e6, "7.5", "the same of recognition")),
        above(optional(&C::v50_identify, "v50_identify", 0.0, 1e6, "13.0", "the same of identification")),
        below(above(optional(&C::probability, "probability", 0.0, 1.0, "0.5",
                             "of detection, recognition, identification at their ranges")))};
  }
};

inline constexpr std::array<double, 3> kN50{0.75, 3.0, 6.0};  ///< to detect, recognise, identify by the 2-D MRTD

/// The picture at the eye.
template <class S>
struct Viewing {
  S magnification{1};
  S field_deg{10};
};

/// Throws UsageError where conditions say nothing of it, and for a display without a format of the frame.
template <class S>
Viewing<S> viewing_of(const Conditions& conditions, const mtf::Frame<S>& frame) {
  using std::atan;
  using std::sqrt;
  if (conditions.magnification) return {.magnification = S(*conditions.magnification)};
  if (!conditions.display_height_m || !conditions.viewing_distance_m)
    throw mtf::UsageError("no [conditions] magnification, or display_height and viewing_distance");
  if (frame.columns <= 0 || frame.rows <= 0)
    throw mtf::UsageError(
        "no [frame] format, whose picture fills [conditions] display_height; write format = [640, 512] (columns, rows) "
        "in [frame], or give magnification in place of the display");
  const S height(*conditions.display_height_m / *conditions.viewing_distance_m);
  const S rows_um = S(frame.rows) * frame.pitch_y_um, columns_um = S(frame.columns) * frame.pitch_x_um;
  const S magnification = height * frame.focal_length_mm * S(1e3) / rows_um;
  const S width = height * columns_um / rows_um;
  return {magnification, S(360.0 / mtf::kPi) * S(sqrt(S(atan(S(0.5) * height)) * S(atan(S(0.5) * width))))};
}

}  // namespace radiometry
