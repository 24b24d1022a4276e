// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sampled curves of the wavelength: quantum efficiency, transmission of filters and optics, emissivity, spectral
// radiance. Between samples a curve is a straight line; outside its range it is 0, so that an integral covers what all
// curves have in common. A curve of one sample is a constant: it has that value at every wavelength.

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace radiometry {

/// Wavelengths from lo_um to hi_um.
struct Interval {
  double lo_um = 0.0;
  double hi_um = std::numeric_limits<double>::infinity();
};

struct Spectrum {
  std::string source;                 ///< where it came from, for messages
  std::vector<double> wavelength_um;  ///< strictly rising, 1e-6 to 1e12
  std::vector<double> value;          ///< >= 0
};

/// A curve ready for use. Throws UsageError (with `source`) for no samples, sizes that differ, wavelengths that do not
/// rise or are not from 1e-6 to 1e12 um, values that are negative, not finite, or above `most` (1 for efficiencies,
/// transmissions and emissivities).
Spectrum make_spectrum(std::string source, std::vector<double> wavelength_um, std::vector<double> value,
                       double most = std::numeric_limits<double>::max());
/// The same value at every wavelength.
Spectrum constant_spectrum(std::string source, double value, double most = std::numeric_limits<double>::max());

/// From the first to the last sample; every wavelength for a constant.
Interval range_of(const Spectrum& spectrum);

/// Linear between the samples, 0 outside of them. The wavelength is finite and above 0.
double evaluate(const Spectrum& spectrum, double wavelength_um);

/// What the band and the ranges of all curves have in common. Throws UsageError with both ranges when that is nothing,
/// for a band that does not rise, and for curves that make_spectrum would refuse for their sizes.
Interval common_range(const Interval& band, std::span<const Spectrum> factors);

/// The ends of the interval and the samples of all curves inside it, rising.
std::vector<double> union_grid(const Interval& interval, std::span<const Spectrum> factors);

/// The product of the curves, sampled on the union of their grids over what they have in common; a constant for
/// constants. Between the samples it is a line where the true product is a polynomial: integrals take the curves
/// themselves (band_response.h). Throws UsageError when they have nothing in common.
Spectrum product(std::string source, std::span<const Spectrum> factors);

/// "3.4 um to 4.8 um", for messages.
std::string describe(const Interval& interval);

}  // namespace radiometry
