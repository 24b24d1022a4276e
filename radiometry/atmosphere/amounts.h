// SPDX-License-Identifier: Apache-2.0
#pragma once

// How much of each absorber a line of sight goes through.
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
#include <vector>

#include "radiometry/atmosphere/sight.h"

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

}  // namespace radiometry::atmosphere
