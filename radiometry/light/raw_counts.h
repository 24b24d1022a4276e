// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts of radiometric thermal cameras, which store five constants with each image:
//   S + O = R1 / (R2 (exp(B / T) - F)),   T = B / ln(R1 / (R2 (S + O)) + F)
// S is the count, T the temperature in K of a blackbody that gives it; S + O is proportional to the radiance in the
// camera's band. With U(T) = R1 / (R2 (exp(B / T) - F)), of a surface of emissivity e before surroundings, behind air
// of transmission t and a window of transmission w,
//   S + O = w (t (e U(T) + (1 - e) U(T_reflected)) + (1 - t) U(T_air)) + (1 - w) U(T_window),
// which is solved for T. The constants include the camera's optics. (F is 1 where the band is narrow: Planck's law with
// B = c2 / wavelength.) Source: FLIR Systems, ThermoVision SDK user's manual, "the measurement formula"; its air is
//   t = X exp(-sqrt(d) (a1 + b1 sqrt(h))) + (1 - X) exp(-sqrt(d) (a2 + b2 sqrt(h))),
//   h = humidity exp(1.5587 + 6.939e-2 c - 2.7816e-4 c^2 + 6.8455e-7 c^3), c the air temperature in degrees Celsius
// with the distance d in m and constants a, b, X that the camera stores.

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

struct CountCamera {
  double r1 = 0.0;  ///< counts
  double b_k = 0.0;
  double f = 1.0;
  double o = 0.0;  ///< counts
  double r2 = 1.0;

  /// K; NaN where the formula has no temperature above 0.
  double temperature_k(double count) const;
  double count(double temperature_k) const;

  static constexpr auto fields() {
    return std::tuple{above(row_between(&CountCamera::r1, "R1", "", 0.0, 1e12, "scale of the counts")),
                      above(row_between(&CountCamera::b_k, "B", "K", 0.0, 1e9, "c2 over the mean wavelength")),
                      above(row_between(&CountCamera::f, "F", "", 0.0, 1e3, "in place of the 1 of Planck's law")),
                      above(row_between(&CountCamera::o, "O", "", -1e12, 1e12, "added to the counts")),
                      above(row_between(&CountCamera::r2, "R2", "", 0.0, 1e12, "further scale of the counts"))};
  }
};

/// What the thermometer assumes of the surface and of what lies before it. Emissivity and transmissions in (0, 1];
/// temperatures of parts that count nothing are of no effect.
struct Thermometry {
  double emissivity = 1.0;
  double reflected_k = 293.15;  ///< apparent temperature of what is reflected
  double transmission = 1.0;    ///< of the air
  double air_k = 293.15;
  double window_transmission = 1.0;
  double window_k = 293.15;
};

/// The air that a camera is told of, with its constants a, b and X.
struct CountAir {
  double distance_m = 0.0, air_k = 293.15, humidity = 0.5;
  double alpha1 = 0.006569, alpha2 = 0.01262, beta1 = -0.002276, beta2 = -0.00667, x = 1.9;
};
/// NaN where the formula gives no transmission above 0, up to 1.
double transmission_of(const CountAir& air);

/// The temperature of the surface in K; NaN where there is none.
double temperature_of(double count, const CountCamera& camera, const Thermometry& assumed);

/// By how much that temperature changes with what is assumed: partial derivatives, K for a unit of each.
struct CountSensitivity {
  double emissivity = 0.0, reflected = 0.0, transmission = 0.0, air = 0.0;
};
CountSensitivity sensitivity_of(double count, const CountCamera& camera, const Thermometry& assumed);

/// Counts become the temperature of the surface in K, in place. NaN stays NaN. Throws UsageError for constants out of
/// bounds, and, before a pixel is changed, for counts without a temperature: how many, and the first one.
void temperature_of_counts(mtf::ImageView<float> plane, const CountCamera& camera, const Thermometry& assumed = {},
                           int threads = 1);

}  // namespace radiometry
