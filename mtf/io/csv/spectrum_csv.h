// SPDX-License-Identifier: Apache-2.0
#pragma once

// Curves of the wavelength from CSV files: quantum efficiency, transmission, emissivity, spectral radiance.
//   # InSb, 77 K, data sheet of 2024
//   wavelength_nm,quantum_efficiency
//   3400,0.82
//   4800,0.78
// One column is a wavelength, wavenumber or frequency and carries its unit; the units are those of spectral_units.h,
// and percent and spectral densities are converted too. Rows may come in any order. A single row is a constant. Paths
// of several ranges follow one another:
//   range_km,wavelength_um,transmission,radiance_w_m2_sr_um
//   1,3.4,0.61,0.05

#include <string>
#include <string_view>
#include <vector>

namespace mtf::io {

struct SpectrumColumns {
  std::string source;
  std::vector<double> wavelength_um;         ///< strictly rising, above 0
  std::vector<std::vector<double>> columns;  ///< one for each name asked for, >= 0, W m^-2 sr^-1 um^-1 or plain
};

/// The columns called `names` (plain words: "quantum_efficiency"; the unit is not part of the name). A file with one
/// value column gives that one to a single name, whatever it is called. At most a million rows and 64 MiB. Throws
/// RuntimeError when it cannot be read, UsageError "file:line: ..." for what is wrong in it.
SpectrumColumns read_spectrum_csv(const std::string& path, const std::vector<std::string>& names);
/// The same from text.
SpectrumColumns parse_spectrum_csv(std::string_view text, const std::string& source,
                                   const std::vector<std::string>& names);

/// Transmission and radiance of a path for several ranges, all at the same wavelengths: one curve per range.
struct PathColumns {
  std::string source;
  std::vector<double> range_m{};                    ///< strictly rising, above 0
  std::vector<double> wavelength_um{};              ///< strictly rising, above 0
  std::vector<std::vector<double>> transmission{};  ///< 0 to 1
  std::vector<std::vector<double>> radiance{};      ///< W m^-2 sr^-1 um^-1, >= 0
};

/// Columns range_m or range_km, wavelength, transmission, radiance with its unit. Errors as above; both terms are
/// needed, and every range has the same wavelengths.
PathColumns read_path_csv(const std::string& path);
PathColumns parse_path_csv(std::string_view text, const std::string& source);

}  // namespace mtf::io
