// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an exposed surface gives off at a temperature, and its derivative, for one facet; the loops of lanes.cpp have
// the same for many.

#include <cmath>

#include "radiometry/heat/construction.h"
#include "radiometry/heat/evaporation.h"
#include "radiometry/heat/forcing.h"
#include "radiometry/light/constants.h"

namespace radiometry::heat {

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
