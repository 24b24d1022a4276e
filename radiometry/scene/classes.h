// SPDX-License-Identifier: Apache-2.0
#pragma once

// Classes: sides that would have nearly the same temperature history, so that one of them is solved for all.
//
// Two sides of the same construction are merged when the flux that they absorb differs by less than a tolerance at
// every direction of the sun. With absorbed flux
//   q = a [E(d) max(0, n . d) V(d) + sum_r F_r D_r + F_ground D_ground + F_surfaces D_surfaces]
//     + eps [sum_r F_r L_r + F_ground L_ground + F_surfaces L_surfaces]
// (a solar absorptance, eps emissivity, E direct normal irradiance, V visibility, F view shares, D and L solar and
// long-wave radiation of what is seen, as irradiance of a surface that sees nothing else), the difference of two sides
// is at most
//   max over d of |difference of the direct term| + |difference of the diffuse term| + |difference of the long-wave
//   term|
// at every time at which E, D and L are not above the amplitudes given here and have the same distribution over rings.
// The temperatures of the two then differ by at most that over (h_min + 4 eps sigma T_min^3): 0.1 K is about 1 W/m2.
//
// A class is led by its first side; a side joins a class when its bound to the leader is below the tolerance. What is
// stated is the largest bound that was used.

#include <cstdint>
#include <span>
#include <vector>

#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"

namespace radiometry::scene {

/// The largest irradiances of the period, W m^-2.
struct FluxAmplitudes {
  std::vector<double> direct;        ///< normal irradiance by the sun, for each direction of the visibility table
  std::vector<double> sky_solar;     ///< for each ring: that of a surface that sees only this ring
  std::vector<double> sky_longwave;  ///< for each ring; as differences from a mean, where only these matter
  double ground_solar = 0.0, ground_longwave = 0.0;
  double surfaces_solar = 0.0, surfaces_longwave = 0.0;  ///< of other facets
};

/// Of each side: what decides beside its view. Sides with different keys are never merged.
struct SideFinish {
  std::uint32_t key = 0;  ///< construction, material, interior, schedule
  double solar_absorptance = 1.0;
  double emissivity = 1.0;
};

struct Classes {
  std::vector<std::uint32_t> class_of{};  ///< of each side
  std::vector<std::uint32_t> leader{};    ///< of each class: an index into the sides; the one to solve
  double bound_w_m2 = 0.0;                ///< largest difference of absorbed flux between a side and its leader

  std::size_t size() const { return leader.size(); }
};

/// `views`, `sun` and `finish` have an entry for each of `sides`; `to_sun` are the directions of `sun`. With a
/// tolerance of 0 each side is a class. Throws mtf::UsageError when sizes do not fit each other and for numbers out of
/// range.
Classes classes_of(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                   const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                   const FluxAmplitudes& amplitudes, double tolerance_w_m2, int threads = 0);

/// Patches for exchange.h: at most `most` groups of sides of the same finish whose absorbed fluxes, averaged over the
/// first and over the second half of the directions and without the sun, differ by less than a bound, the smallest that
/// makes so few. Meant for the leaders of classes, so that each class lies in one patch. Throws mtf::UsageError as
/// classes_of, and when there are more finishes than `most`.
Classes patches_of(const Facets& facets, std::span<const Side> sides, std::span<const SideFinish> finish,
                   const Views& views, const SunVisibility& sun, std::span<const Vector> to_sun,
                   const FluxAmplitudes& amplitudes, std::size_t most, int threads = 0);

}  // namespace radiometry::scene
