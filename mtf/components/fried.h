// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fried parameter r0 of a path of length L from its refractive-index structure parameter Cn2 (m^(-2/3)):
//   r0 = [0.423 (2 pi/lambda)^2 M]^(-3/5),  M = L x integral over s = 0 ... 1 of Cn2(s) w(s) ds
// s runs from the source (the target) to the sensor; w = 1 for a plane wave (source at infinity), s^(5/3) for a
// spherical one. 0.423 is the published rounding of 0.42336 (0.05 % of r0).
// Hufnagel-Valley profile of the altitude h in m, v the wind of the upper atmosphere in m/s, A the value at the ground:
//   Cn2 = 5.94e-53 (v/27)^2 h^10 exp(-h/1000) + 2.7e-16 exp(-h/1500) + A exp(-h/100)
// (HV 5/7: v = 21, A = 1.7e-14; r0 = 5 cm at 0.5 um, zenith.) (Fried, J. Opt. Soc. Am. 56, 1380 (1966); Valley, Appl.
// Opt. 19, 574 (1980); Andrews and Phillips, Laser Beam Propagation through Random Media.)

namespace mtf {

enum class Wave { spherical, plane };

/// Integral of w(s), the mean for a constant profile: 3/8 or 1.
constexpr double constant_path_weight(Wave wave) { return wave == Wave::spherical ? 0.375 : 1.0; }

struct HufnagelValley {
  double wind_m_s = 21.0;
  double ground = 1.7e-14;  ///< A, m^(-2/3)
};

/// Cn2 at an altitude, m^(-2/3).
double structure_parameter(const HufnagelValley& profile, double altitude_m);

/// M/L for a straight path between two altitudes, with its derivatives.
struct PathMean {
  double value = 0.0, by_wind = 0.0, by_ground = 0.0, by_target = 0.0, by_sensor = 0.0;
};
PathMean path_mean(const HufnagelValley& profile, double target_altitude_m, double sensor_altitude_m, Wave wave);

/// 1/r0 in 1/mm, and its derivatives, for M in m^(1/3) and a wavelength in um. M = 0: 0 without derivatives.
struct InverseFried {
  double value_1_mm = 0.0, by_path = 0.0, by_wavelength = 0.0;
};
InverseFried inverse_fried(double path_m13, double wavelength_um);

}  // namespace mtf
