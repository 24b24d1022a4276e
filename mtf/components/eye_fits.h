// SPDX-License-Identifier: Apache-2.0
#pragma once

// The human eye at a display, by published fits. Luminance L in cd/m^2 (1 fL = 3.42626 cd/m^2).
//
// MTF of the eye as an optical instrument, f in cycles/mrad at the eye, pupil diameter d in mm:
//   optics x retina x tremor = exp(-(43.69 f/f0)^i0) exp(-0.375 f^1.21) exp(-0.4441 f^2)
//   f0 = exp(3.663 - 0.0216 d^2 ln d),  i0 = (0.7155 + 0.277/sqrt d)^2
//   d = -9.011 + 13.23 exp(-log10(L in fL)/21.082), less 0.5 with both eyes open
// The fits reproduce their tables for 1e-4 to 1e3 fL and d = 1.5 to 6.6 mm. It has a tip at f = 0, steeper than |f|:
// i0 < 1. (Overington, Vision and Acquisition; the form used by the NVTherm and NV-IPM family of sensor models.)
//
// Contrast sensitivity, 1 over the threshold of the modulation of a grating; u in cycles/degree at the eye, X the
// angular size of the field in degrees:
//   barten_2003    5200 exp(-0.0016 u^2 (1 + 100/L)^0.08)
//                  / sqrt((1 + 144/X^2 + 0.64 u^2) (63/L^0.83 + 1/(1 - exp(-0.02 u^2))))
//   barten_short   a u exp(-b u) sqrt(1 + 0.06 exp(b u)),  b = 0.3 (1 + 100/L)^0.15,
//                  a = 540 (1 + 0.7/L)^-0.2 / (1 + 12/(X (1 + u/3)))
//   barten_short_squared   the same with (1 + u/3)^2
// Both short forms are in use, under one name; they differ by a quarter for a field of 10 degrees: results have to
// name theirs. All are 0 at u = 0, like u. Their fits are made for about 0.1 to 1000 cd/m^2 and fields of 0.5 to 60
// degrees. (Barten, Proc. SPIE 5294, 231 (2003); Barten, J. Opt. Soc. Am. A 7, 2024 (1990).)

#include <array>
#include <string_view>

#include "mtf/component.h"

namespace mtf {

inline constexpr double kLuminanceLo = 3.4e-4;  ///< cd/m^2, 1e-4 fL
inline constexpr double kLuminanceHi = 3.5e3;   ///< cd/m^2, 1e3 fL

/// Diameter of the pupil in mm, and its slope by luminance. `eyes` is 1 or 2.
ValueSlope pupil_diameter_mm(double luminance_cd_m2, int eyes);

/// Scale and exponent of the MTF of the eye's optics, and their slopes by the pupil.
struct EyeOptics {
  ValueSlope f0;
  ValueSlope i0;
};
EyeOptics eye_optics(double pupil_mm);

/// MTF of optics, retina and tremor at f >= 0, with its derivatives. At f = 0 they are given as 0.
struct EyeMtf {
  double value = 0.0, by_frequency = 0.0, by_pupil = 0.0;
};
EyeMtf eye_mtf(double f_cy_mrad, double pupil_mm);

enum class ContrastModel { barten_2003, barten_short, barten_short_squared };
inline constexpr std::array<std::string_view, 3> kContrastModelNames{"barten_2003", "barten_short",
                                                                     "barten_short_squared"};

/// Sensitivity at u >= 0, with its derivatives (one-sided at u = 0).
struct ContrastSensitivity {
  double value = 0.0, by_frequency = 0.0, by_luminance = 0.0, by_field = 0.0;
};
ContrastSensitivity contrast_sensitivity(ContrastModel model, double u_cy_deg, double luminance_cd_m2,
                                         double field_deg);

/// Where the sensitivity is largest.
double peak_frequency_cy_deg(ContrastModel model, double luminance_cd_m2, double field_deg);

}  // namespace mtf
