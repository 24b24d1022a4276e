// SPDX-License-Identifier: Apache-2.0
#pragma once

// The path between scene and aperture: what it takes and what it adds, always together.
//   L at the aperture = tau L of the scene + L of the path
//   L of the path = given spectral radiance + emissivity x Planck(temperature of the air)
// (for a path in the thermal bands that only absorbs the emissivity is 1 - tau).

#include <vector>

#include "radiometry/light/spectrum.h"

namespace radiometry {

/// By default a path that transmits all and adds nothing.
struct Path {
  Spectrum transmission = constant_spectrum("transmission of the path", 1.0);
  Spectrum radiance = constant_spectrum("radiance of the path", 0.0);      ///< W m^-2 sr^-1 um^-1
  Spectrum emissivity = constant_spectrum("emissivity of the path", 0.0);  ///< of the air, thermal emission
  double air_temperature_k = 0.0;
};

/// A path that is the same at all wavelengths. transmission in [0, 1], radiance in W m^-2 sr^-1 um^-1, >= 0.
Path constant_path(double transmission, double radiance);
/// Air of one temperature that only absorbs: its emissivity is 1 - transmission.
Path absorbing_path(const Spectrum& transmission, double air_temperature_k);

/// 1 - curve, for a curve of values up to 1 (UsageError for others): reflectance of an opaque surface, absorption.
Spectrum complement(const Spectrum& spectrum);

/// Transmission and radiance of paths of several lengths, at the same wavelengths. Between two lengths log tau goes as
/// a straight line of the range (Beer's law; bands that fall fast and then flatten are followed as densely as the table
/// is), tau itself where an end is 0; the radiance of the path as a straight line. Range 0 takes and adds nothing.
class PathTable {
 public:
  /// One curve per range; ranges rise and are above 0. Throws UsageError for others, for sizes that differ, no ranges,
  /// transmissions above 1 and what make_spectrum refuses.
  PathTable(std::string source, std::vector<double> range_m, std::vector<double> wavelength_um,
            std::vector<std::vector<double>> transmission, std::vector<std::vector<double>> radiance);

  /// The path of that length. Throws UsageError beyond the last range, below 0 and for NaN.
  Path at(double range_m) const;

  const std::string& source() const { return source_; }
  const std::vector<double>& range_m() const { return range_m_; }
  const std::vector<double>& wavelength_um() const { return wavelength_um_; }
  /// One curve per range.
  const std::vector<std::vector<double>>& transmission() const { return transmission_; }
  const std::vector<std::vector<double>>& radiance() const { return radiance_; }

 private:
  std::string source_;
  std::vector<double> range_m_;
  std::vector<double> wavelength_um_;
  std::vector<std::vector<double>> transmission_, radiance_;
};

}  // namespace radiometry
