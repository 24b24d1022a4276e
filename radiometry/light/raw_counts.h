// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts of radiometric thermal cameras, which store five constants with each image:
//   S + O = R1 / (R2 (exp(B / T) - F)),   T = B / ln(R1 / (R2 (S + O)) + F)
// S is the count, T the temperature in K of a blackbody that gives it; S + O is proportional to the radiance in the
// camera's band. A surface that reflects its surroundings has S + O = e (S + O of it) + (1 - e)(S + O of what is
// reflected), which is solved for its temperature. The constants include the camera's optics; air between is left out.
// (F is 1 where the band is narrow: Planck's law with B = c2 / wavelength.)

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

/// What the thermometer assumes of the surface. emissivity in (0, 1].
struct Reflection {
  double emissivity = 1.0;
  double reflected_k = 293.15;  ///< apparent temperature of what is reflected; of no effect for emissivity 1
};

/// Counts become the temperature of the surface in K, in place. NaN stays NaN. Throws UsageError for constants out of
/// bounds, and, before a pixel is changed, for counts without a temperature: how many, and the first one.
void temperature_of_counts(mtf::ImageView<float> plane, const CountCamera& camera, const Reflection& reflection = {},
                           int threads = 1);

}  // namespace radiometry
