// SPDX-License-Identifier: Apache-2.0
#pragma once

// A thermal camera from stacks of frames of blackbodies that fill its field. The mean count of a stack is linear in the
// radiance of its blackbody in the camera's band, not in the temperature:
//   mean = c + K L,   SiTF = K dL/dT,   NETD = sqrt(MS_tvh) / SiTF,   noise in kelvin = component / SiTF
// L and dL/dT are integrals of Planck's law over the band, which the caller takes from the sensor file
// (radiometry/light/spectral_signal.h); dL/dT is that of a blackbody of emissivity 1 at the reference temperature. (The
// secant of counts over temperature from 298 to 308 K is 5 % above the slope at 298 K, in 8 to 13 um.)
//   random      falls with the frames: the variance of a mean over T frames of P pixels is f MS_tvh / (T P), f the mean
//               square of the frames' means over that of the pixels, pooled over the stacks; so frames that flicker as
//               a whole widen it. Limits take Student's t of its degrees of freedom.
//   systematic  does not: the temperature of each blackbody (independent of the others') and their emissivity (common
//               to all), propagated through the weighted fit and stated apart
// The 95 % interval holds both. Three or more radiances test the line: what is beyond noise and temperature_sd is a
// misfit. Limits of a root over a slope are those of the variance (components.h) and of the slope, put together by
// their distances from the estimate (G. Y. Zou and A. Donner, Stat. Med. 27, 1693 (2008)).
//
// SiTF and NETD are those of G. C. Holst, Testing and Evaluation of Infrared Imaging Systems, and ASTM E1543.

#include <vector>

#include "calib/characterize/characterize.h"

namespace calib {

struct ThermalOptions {
  double reference_k = 300.0;     ///< at which kelvin are meant
  double radiance = 0.0;          ///< of a blackbody of emissivity 1 there
  double radiance_per_k = 0.0;    ///< dL/dT of it
  double own_radiance = 0.0;      ///< what the camera adds by its own warmth, as radiance before it; may be below 0
  double temperature_sd_k = 0.0;  ///< of each blackbody
  double emissivity_sd = 0.0;     ///< of all of them
  double misfit_p = 1e-3;         ///< below, the counts are no line over the radiance
};

/// Why so many stacks, whose radiances differ or not, do not tell SiTF; "" where they do.
std::string too_few_radiances(std::size_t stacks, bool differ);

/// The stack that tells the noise, the patterns and the blinking pixels: usable, of the radiance nearest to that one,
/// and of equals the darker. Null where there is none.
const Stack* nearest_stack(const std::vector<Stack>& stacks, double radiance);

/// `light` of a stack is the radiance of its blackbody in the band, with what that reflects. Findings: sitf (counts/K);
/// offset, the count without any light; netd and the seven components of 3-D noise, noise_t to noise_tvh (mK), of the
/// stack whose radiance is nearest to the reference; prnu of pixels, from the hottest less the coldest stack; dsnu
/// (mK), what noise_vh has beside the prnu of the signal. `transfer` has the fitted means and chi-square; of variances
/// it says nothing (NaN). Throws UsageError, naming stack and remedy: for stacks as require_sound(), for fewer than two
/// radiances that are not clipped, counts that do not rise with the radiance, and noise that rounding hides.
Characterization characterize_thermal(std::vector<Stack> stacks, const ThermalOptions& options);

}  // namespace calib
