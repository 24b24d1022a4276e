// SPDX-License-Identifier: Apache-2.0
#pragma once

// The coefficients of the model on its grid of wavenumbers, as tables/coefficients.inc holds them, ready for use.

#include <span>
#include <vector>

#include "radiometry/atmosphere/amounts.h"
#include "radiometry/atmosphere/spectral_path.h"

namespace radiometry::atmosphere {

inline constexpr std::size_t kWavenumbers = 1646;  ///< of the grid: 650 ... 3500 by 5, 3520 ... 25000 by 20 cm^-1
inline constexpr std::size_t kEmissionWavenumbers = 571;  ///< of those with radiance
double wavenumber_cm(std::size_t index);

/// tau = exp(-(C W)^a), W the amount of a gas with its exponents of pressure and temperature.
struct BandLaw {
  Gas gas;
  double a, n, m;
};
std::span<const BandLaw> band_laws();
Component component_of(Gas gas);

/// Optical depth per amount on the indices first, first + 1, ...; of lines per amount^a.
struct Coefficients {
  std::size_t first = 0;
  std::span<const double> value;
};
struct BandModel {
  std::vector<std::vector<Coefficients>> lines;  ///< of each band, C^a
  std::vector<double> values;                    ///< what `lines` refers to
  Coefficients water_foreign, water_self_296, water_self_260, nitrogen;
  std::array<Coefficients, 3> oxygen;
  std::vector<double> molecules;
  std::vector<int> aerosol_node;      ///< the wavelength of the aerosol's spectra below each index
  std::vector<double> aerosol_share;  ///< how far on the way to the next one
};
const BandModel& band_model();

/// Extinction, or what of it is absorbed, over the extinction at 0.55 um, at the wavelengths of the spectra.
using AerosolSpectrum = std::span<const double, kAerosolNodes>;
inline constexpr std::array<double, 4> kHazeHumidities{0.0, 70.0, 80.0, 99.0};
double haze_humidity_share();  ///< of the relative humidity that counts: see tables/coefficients.inc
/// Of rural, urban, maritime, tropospheric haze.
AerosolSpectrum haze_spectrum(HazeKind kind, AerosolLoss loss, std::size_t humidity);
AerosolSpectrum fog_spectrum(HazeKind kind, AerosolLoss loss);
AerosolSpectrum upper_spectrum(AerosolRegion region, AerosolLoss loss);  ///< all but the boundary

/// Extinction at 0.55 um per km at the altitudes of the tables.
double boundary_aerosol(std::size_t visibility, std::size_t altitude);  ///< 50, 23, 10, 5, 2 km; 0, 1, 2 km
double tropospheric_aerosol(Season season, std::size_t visibility, std::size_t altitude);  ///< 50, 23 km; 3 ... 10 km
double stratospheric_aerosol(Season season, std::size_t altitude);                         ///< 11 ... 25, 30 km
double upper_aerosol(std::size_t altitude);  ///< 35, 40, 45, 50, 70, 100 km

}  // namespace radiometry::atmosphere
