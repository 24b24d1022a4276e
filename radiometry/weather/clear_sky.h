// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solar irradiance under a clear sky: Bird and Hulstrom, "A Simplified Clear Sky Model for Direct and Diffuse
// Insolation on Horizontal Surfaces", SERI/TR-642-761 (1981). With M the relative air mass of Kasten (Arch. Meteorol.
// Geophys. Bioklimatol. B 14, 206 (1966)), M' = M p / 1013.25 hPa and tau = 0.27583 tau(380 nm) + 0.35 tau(500 nm):
//   Rayleigh  T_R = exp(-0.0903 M'^0.84 (1 + M' - M'^1.01))
//   ozone     T_O = 1 - 0.1611 x (1 + 139.48 x)^-0.3034 - 0.002715 x / (1 + 0.044 x + 0.0003 x^2),   x = M ozone / cm
//   gases     T_G = exp(-0.0127 M'^0.26)
//   water     T_W = 1 - 2.4959 w / ((1 + 79.034 w)^0.6828 + 6.385 w),                                w = M water / cm
//   aerosol   T_A = exp(-tau^0.873 (1 + tau - tau^0.7088) M^0.9108);  absorbed T_AA = 1 - 0.1 (1 - M + M^1.06)(1 - T_A)
//   beam      I_n = 0.9662 E_0 T_A T_W T_G T_O T_R                                       of a plane that faces the sun
//   scattered I_s = 0.79 E_0 cos z T_O T_G T_W T_AA (0.5 (1 - T_R) + B_a (1 - T_A / T_AA)) / (1 - M + M^1.02)
//   global    I   = (I_n cos z + I_s) / (1 - albedo r_s),   r_s = 0.0685 + (1 - B_a)(1 - T_A / T_AA);  diffuse I - I_n
//   cos z
// The authors found agreement with rigorous spectral models to 10 %.

namespace radiometry::heat {

struct ClearSkyAir {
  double pressure_pa = 101325.0;     ///< at the place, not reduced to sea level
  double ozone_cm = 0.3;             ///< column at standard conditions
  double water_cm = 1.5;             ///< precipitable water
  double aerosol_depth_500nm = 0.1;  ///< optical depth of a vertical path
  double aerosol_depth_380nm = 0.15;
  double forward_scatter_ratio = 0.85;  ///< B_a: share of the aerosol's scattered light that goes on towards the ground
  double albedo = 0.2;                  ///< of the ground, for light that goes up and comes back
};

struct SolarIrradiance {
  double direct_normal_w_m2 = 0.0;  ///< beam on a plane that faces the sun
  double diffuse_horizontal_w_m2 = 0.0;
  double global_horizontal_w_m2 = 0.0;  ///< direct normal x cos z + diffuse
};

/// Irradiance with the sun at `zenith_rad`; 0 from 89 deg on, where the air mass formula is no longer good.
/// `extraterrestrial_w_m2`: normal to the beam outside of the atmosphere, sun.h. UsageError for values of no air.
SolarIrradiance clear_sky(const ClearSkyAir& air, double zenith_rad, double extraterrestrial_w_m2);

/// 1 / (cos z + 0.15 (93.885 - z / deg)^-1.25), z below 93 deg; Kasten himself has the exponent 1.253.
double relative_air_mass(double zenith_rad);

/// Pressure in Pa of the standard atmosphere at an altitude: 101325 (1 - 2.25577e-5 h)^5.25588 (ISO 2533), h below
/// 11 km.
double standard_pressure_pa(double altitude_m);

}  // namespace radiometry::heat
