// SPDX-License-Identifier: Apache-2.0
#pragma once

// How much of each absorber a line of sight goes through.
//   lines of a gas      W = integral of u (P / P0)^n (T0 / T)^m ds, one per gas and band (n and m belong to the band:
//                       band_model.h); u in molecules per cm^2 over 1e20
//   water continuum     integral of h^2 ds (self), theta h^2 ds (its rise with cold), h (N - h) ds (foreign), h and N
//                       molecules per cm^3 of vapour and air; theta = (296 K - T) / 36 K within 0 ... 1, T the mean of
//                       the layer
//   N2 continuum        integral of (P / P0)^2 (T0 / T)^1.5 ds; O2 continuum: three powers of the temperature
//   molecules           integral of (P / P0) (T0 / T) ds (Rayleigh)
//   aerosol             extinction at 0.55 um, of each region; rain: extinction
// A layer lies between two neighbouring levels, cut where the line starts and ends. Inside of it each of these
// densities goes exponentially with altitude (as a straight line where an end is 0), its mean temperature is the
// integral of the pressure over that of the density.

#include <array>
#include <vector>

#include "radiometry/atmosphere/sight.h"

namespace radiometry::atmosphere {

/// Of one layer of a line of sight, or summed from the sensor on.
template <class S>
struct Amounts {
  std::vector<S> lines;  ///< one a band of the model, in its order (band_model.h)
  S water_self{}, water_self_cold{}, water_foreign{};
  S nitrogen{};
  std::array<S, 3> oxygen{};
  S molecules{};
  std::vector<S> aerosol;  ///< one a spectrum of the model, in its order: the boundary region's by humidity
  S rain{};
};

template <class S>
struct PathLayer {
  Amounts<S> amounts;  ///< of this layer alone
  S temperature_k{};   ///< its mean
  S length_m{};
};

/// From the sensor on. Throws UsageError as sight_numbers.
template <class S>
std::vector<PathLayer<S>> path_layers(const Air<S>& air, const Sight<S>& sight);

}  // namespace radiometry::atmosphere
