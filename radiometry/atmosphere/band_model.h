// SPDX-License-Identifier: Apache-2.0
#pragma once

// The coefficients of the model on its grid of wavenumbers, as tables/coefficients.inc holds them, ready for use; and
// what they are multiplied by: how much of each absorber a line of sight goes through.
//   lines of a gas    W = integral of u (P / P0)^n (T0 / T)^m ds, one per gas and band (n and m belong to the band);
//                     u in 1e20 molecules per cm^2, P0 = 1013.25 hPa, T0 = 296 K
//   water continuum   integral of h (N - h) ds (foreign) and of h^2 ds (self), the latter shared between 296 and 260 K
//                     by theta = (296 K - T) / 36 K within 0 ... 1; h and N molecules of vapour and air, 1e19 per cm^3
//   nitrogen          integral of (P / P0)^2 (T0 / T)^1.5 ds
//   oxygen            collision-induced: integral of u (P / P0) ds, times 1, t, t^2 with t = (T - 250 K) / 100 K
//   molecules         integral of (P / P0) (T0 / T) ds, Rayleigh scattering
//   aerosol           optical depth at the wavelengths between which the spectra are straight lines: extinction at
//                     0.55 um from the sensor to the layer's end times the spectrum at their mean humidity (weighted by
//                     extinction), less that to its start. Where that would fall with range it stays
//   rain              optical depth
// Lengths in km but for u. A layer lies between two neighbouring levels, those of the profile and, within the profile,
// every kilometre to 25 km and 30, 35, 40, 45, 50, 70 and 100 km; it is cut where the line starts and ends. In it each
// of these densities goes exponentially with altitude (as a straight line where an end is 0). theta and t are those of
// the layer's mean temperature, the integral of the pressure over that of the density.

#include <array>
#include <span>
#include <vector>

#include "radiometry/atmosphere/sight.h"
#include "radiometry/atmosphere/spectral_path.h"

namespace radiometry::atmosphere {

inline constexpr std::size_t kLineBands = 36;     ///< gases x bands of equal n and m
inline constexpr std::size_t kAerosolNodes = 32;  ///< wavelengths

template <class S>
struct Amounts {
  std::array<S, kLineBands> lines{};
  S water_foreign{}, water_self_296{}, water_self_260{};
  S nitrogen{};
  std::array<S, 3> oxygen{};
  S molecules{};
  std::array<S, kAerosolNodes> aerosol{};
  S rain{};
};

template <class S>
struct PathLayer {
  Amounts<S> amounts;  ///< of this layer alone
  S temperature_k{};   ///< its mean
  S length_m{};
};

/// From the sensor on. Throws UsageError as sight_numbers does.
template <class S>
std::vector<PathLayer<S>> path_layers(const Air<S>& air, const Sight<S>& sight);

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
