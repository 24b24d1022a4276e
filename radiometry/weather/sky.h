// SPDX-License-Identifier: Apache-2.0
#pragma once

// Long-wave (thermal) irradiance of a horizontal plane by the sky, from values at screen height: air temperature T in
// K, vapour pressure e. Clear sky, with e in hPa:
//   Brunt      sigma T^4 (0.52 + 0.065 sqrt e)    Brunt, Q. J. R. Meteorol. Soc. 58, 389 (1932)
//   Brutsaert  sigma T^4 1.24 (e / T)^(1/7)       Brutsaert, Water Resour. Res. 11, 742 (1975)
//   Swinbank   5.31e-13 T^6 (W/m2)                Swinbank, Q. J. R. Meteorol. Soc. 89, 339 (1963)
// Clouds that cover the fraction n of the sky raise each by the factor 1 + 0.22 n^2.75 (Maykut and Church, J. Appl.
// Meteorol. 12, 620 (1973), of Barrow, Alaska; other sites have found less, Sugita and Brutsaert, Water Resour. Res.
// 29, 599 (1993), 1 + 0.05 n^2.45). Such formulas are good to 10 ... 30 W/m2, which is 2 ... 6 K of an insulated
// surface: a measured value is better where there is one.

namespace radiometry::heat {

enum class SkyModel { brunt, brutsaert, swinbank };

/// Pressure of saturated vapour over water, Magnus form of the WMO's guide (WMO-No. 8, annex 4.B):
/// 611.2 Pa exp(17.62 t / (243.12 + t)), t in degC, for -45 ... 60 degC.
double saturation_pressure_pa(double temperature_k);
/// The inverse: the dew point of air with that vapour pressure (above 0).
double dew_point_k(double vapour_pressure_pa);

/// W/m2 under a clear sky. Throws UsageError for temperatures that are not above 0 and vapour pressures below 0.
double clear_sky_longwave_w_m2(SkyModel model, double air_temperature_k, double vapour_pressure_pa);

/// 1 + 0.22 n^2.75; throws UsageError unless 0 <= n <= 1.
double cloud_factor(double cover);

/// The cover n that makes cloud_factor(n) the quotient of a measured and a clear-sky irradiance: 0 where the sky is
/// colder than the formula, 1 where it is warmer than covered.
double cloud_cover_from_longwave(double measured_w_m2, double clear_w_m2);

/// sigma T^4, W/m2.
double blackbody_w_m2(double temperature_k);
/// Temperature in K of the black body of that irradiance: (L / sigma)^(1/4).
double sky_temperature_k(double longwave_w_m2);

}  // namespace radiometry::heat
