// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units in the headers of spectral tables, after the name of the column:
//   wavelength_nm   "wavelength (um)"   lambda_m   wavenumber_cm-1   "wavenumber (1/cm)"   frequency_THz
//   radiance_w_m2_sr_um   "radiance (W/m^2/sr/nm)"   "radiance [uW/cm2/sr/nm]"   "radiance (W/cm^2/sr/cm^-1)"
//   quantum_efficiency_percent   "transmission (%)"
// Everything becomes um, W m^-2 sr^-1 um^-1 and plain fractions: wavelength = 1e4 um / wavenumber in cm^-1
// = c / frequency, and a density per wavenumber k is k^2 / 1e4 times as much per um.

#include <optional>
#include <string>
#include <string_view>

namespace mtf::io {

/// "Quantum efficiency [%]" -> "quantum_efficiency": words of letters and digits in lower case, the micro sign as u.
std::string plain_words(std::string_view cell);

/// A unit of the place in the spectrum.
struct SpectralUnit {
  enum class Kind { wavelength, wavenumber, frequency } kind = Kind::wavelength;
  double factor = 1.0;  ///< to um, cm^-1, Hz

  /// In um; not finite or not above 0 for values that are no place in a spectrum.
  double to_um(double value) const;
};

/// The unit of that name ("nm", "um", "m", "cm_1", "1_cm", "thz" ..., as plain_words has it).
std::optional<SpectralUnit> find_spectral_unit(std::string_view plain);

/// What a column is by its header.
struct SpectralColumn {
  std::string name;  ///< plain, without the unit where that is known: "wavelength", "quantum_efficiency", "radiance"
  std::optional<SpectralUnit> place;  ///< of a wavelength, wavenumber or frequency column with a unit
  bool is_place = false;              ///< it is one of those, with or without a unit
  double factor = 1.0;                ///< value x factor is a fraction, or W m^-2 sr^-1 um^-1 ...
  bool per_wavenumber = false;        ///< ... but for another factor (wavenumber in cm^-1)^2 / 1e4
  bool density = false;               ///< the unit is one of a spectral radiance
};
SpectralColumn spectral_column(std::string_view header_cell);

/// Value of a column at a wavelength, in the units above.
double in_our_units(const SpectralColumn& column, double value, double wavelength_um);

}  // namespace mtf::io
