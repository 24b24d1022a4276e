// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an exposed surface gives off at a temperature, and its derivative, for one facet; the loops of lanes.cpp have
// the same for many.
//
// Evaporation from a surface that is wet in part, W/m2 away from the surface; negative where vapour of the air
// condenses on it:
//   q = w (h / gamma) (e_s(T) - e),   gamma = c_p P / (0.622 L)
// the bulk formula with the coefficient h that the wind makes for heat (convection.h; Bowen, Phys. Rev. 27, 779, 1926;
// Monteith & Unsworth, Principles of Environmental Physics, 4th ed., 2013), as the Penman-Monteith equation of FAO-56
// has it (Allen et al., FAO Irrigation and Drainage Paper 56, 1998, eqs. 3 and 8) with a surface temperature that is
// solved and not eliminated. w is the fraction of the surface that is wet, e the vapour pressure of the air, P its
// pressure, L = 2.45 MJ/kg, c_p = 1013 J/kg/K, so that gamma = 0.665e-3 P: 67 Pa/K at sea level. e_s is saturation over
// water by the WMO's Magnus form, 611.2 Pa exp(17.62 t / (243.12 + t)), for -45 ... 60 degC; over ice it is up to a
// third too large. Buoyancy's part of the film carries no vapour here, so that q rises with T everywhere: in still air
// nothing evaporates. w is given, not solved: nothing dries. 20 to 30 % in h is usual, and w is known no better.

#include <cmath>

#include "radiometry/heat/construction.h"
#include "radiometry/heat/convection.h"
#include "radiometry/heat/forcing.h"
#include "radiometry/light/constants.h"

namespace radiometry::heat {

/// The formula of saturation holds where there is water.
inline constexpr Validity kSaturationValidity{
    "evaporation",
    "surface temperature",
    "K",
    273.15,
    333.15,
    "over ice saturation is up to a third less than over water, and above 60 degC the formula is not made for it"};

/// Pa/K.
constexpr double psychrometric_pa_k(double air_pressure_pa) {
  constexpr double kHeat_j_kg_k = 1013.0, kLatent_j_kg = 2.45e6, kMasses = 0.622;
  return kHeat_j_kg_k * air_pressure_pa / (kMasses * kLatent_j_kg);
}

struct Vapour {
  double pressure_pa = 0.0, slope_pa_k = 0.0;
};

/// Saturation and its slope. Below 150 K and above 500 K, where Newton's method may pass, it goes on as a straight
/// line, so that it rises everywhere.
inline Vapour saturation(double kelvin) {
  constexpr double kScale_pa = 611.2, kRate = 17.62, kBase = 243.12, kZero_k = 273.15;
  constexpr double kColdest_k = 150.0, kHottest_k = 500.0;
  const double inside = kelvin < kColdest_k ? kColdest_k : kelvin > kHottest_k ? kHottest_k : kelvin;
  const double t = inside - kZero_k, s = 1.0 / (kBase + t);
  const double pressure = kScale_pa * std::exp(kRate * t * s), slope = pressure * kRate * kBase * s * s;
  return {pressure + slope * (kelvin - inside), slope};
}

struct LossAndSlope {
  double loss, slope;  ///< W/m2; W/m2/K
};

struct SurfaceLoss {
  double emission = 0.0;           ///< epsilon sigma
  double film = 0.0, air_k = 0.0;  ///< of the wind
  NaturalConvection natural;
  double latent = 0.0, vapour_pa = 0.0;  ///< w h / gamma, and the vapour of the air

  /// Below 0 K, which Newton's method may visit, the loss goes on as an odd function, so that it rises everywhere.
  LossAndSlope at(double t) const {
    const double cube = t * t * std::abs(t), excess = t - air_k;
    double c = excess > 0.0 ? natural.warm : natural.cold;
    if (c != 0.0) c *= std::cbrt(std::abs(excess));
    LossAndSlope sum{emission * cube * t + (film + c) * excess, 4.0 * emission * cube + film + 4.0 / 3.0 * c};
    if (latent > 0.0) {
      const Vapour at_surface = saturation(t);
      sum.loss += latent * (at_surface.pressure_pa - vapour_pa);
      sum.slope += latent * at_surface.slope_pa_k;
    }
    return sum;
  }
};

/// W/m2/Pa: w h / gamma.
inline double latent_coefficient(double wet_fraction, double film_w_m2_k, double air_pressure_pa) {
  return wet_fraction > 0.0 ? wet_fraction * film_w_m2_k / psychrometric_pa_k(air_pressure_pa) : 0.0;
}

/// Of the front of a construction, or of its back; `up`: the vertical component of that side's normal.
inline SurfaceLoss surface_loss(const Construction& construction, bool back, const SideForcing& from, double up) {
  const auto* sheet = std::get_if<Sheet>(&construction.inside);
  const bool of_sheet = back && sheet != nullptr;
  const Convection& convection = of_sheet ? sheet->convection : construction.convection;
  const double film = forced_coefficient(convection, from.wind_m_s);
  return {(of_sheet ? sheet->emissivity : construction.emissivity) * kStefanBoltzmann_w_m2_k4,
          film,
          from.air_k,
          natural_coefficient(convection, up),
          latent_coefficient(of_sheet ? sheet->wet_fraction : construction.wet_fraction, film,
                             construction.air_pressure_pa),
          from.vapour_pa};
}

}  // namespace radiometry::heat
