// SPDX-License-Identifier: Apache-2.0
#pragma once

// [conditions] of a study: what metrics need to know of target, scene, observer and geometry.

#include <optional>
#include <string>

namespace study {

struct Conditions {
  double temperature_k = 300.0;  ///< temperature: of the surface that the pixel images
  std::optional<double>
      range_m;                  ///< range: to the target along the line of sight, for GSD and all that follows from it
  double elevation_deg = 90.0;  ///< elevation: of the sensor seen from the target; 90 = overhead
  std::optional<double> contrast_k;  ///< contrast: of the target to its background, K, for ranges and SNR of NIIRS, GRD
  std::optional<double> target_size_m;  ///< target_size: square root of the area, for TTP and Johnson
  std::optional<double>
      signal_contrast;  ///< signal_contrast: (bright - dark)/bright of two reflecting surfaces, for SNR of NIIRS
  double extinction_per_km = 0.0;  ///< extinction: of the apparent contrast with range (Beer), for the ranges
  double scene_contrast_k = 5.0;   ///< scene_contrast: K from dark to mean luminance of the display, for TTP
  double snr_threshold = 2.5;      ///< snr_threshold: of the MRTD
  double eye_time_s = 0.1;         ///< eye_time: integration of the eye
  double frame_rate_hz = 0.0;      ///< frame_rate: 0 = 1 / integration time
  double luminance_cd_m2 = 34.26;  ///< luminance: of the display
  double viewing_magnification =
      1.0;  ///< magnification: angular, display to object, cycles/mrad at the eye = object / it
  double v50_detect = 2.0, v50_recognise = 7.5, v50_identify = 13.0;
};

}  // namespace study
