// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a facet is made of. Heat flows along the depth x alone, from the outer surface at x = 0 inwards:
//   rho c dT/dt = d/dx (k dT/dx)
//   x = 0:  -k dT/dx = absorbed - epsilon sigma T^4 - convection
//   inside: one of
//     adiabatic   no flow
//     fixed       T = the inside value
//     film        k dT/dx = h (inside value - T): an interior of that temperature
//     flux        k dT/dx = the inside value, W/m2 into the construction
//     sheet       a second exposed surface, with absorbed flux, radiation and convection of its own
// Conduction along the surface is left out. Over the length sqrt(k d / h), with d the thickness and h the sum of the
// film and 4 epsilon sigma T^3, it evens out differences: facets that are larger and lit uniformly do not need it.

#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "radiometry/heat/convection.h"

namespace radiometry::heat {

struct Layer {
  double conductivity_w_m_k = 0.0, density_kg_m3 = 0.0, heat_capacity_j_kg_k = 0.0, thickness_m = 0.0;

  double resistance() const { return thickness_m / conductivity_w_m_k; }                  ///< m2 K / W
  double capacity() const { return density_kg_m3 * heat_capacity_j_kg_k * thickness_m; }  ///< J / m2 / K
  double diffusivity() const {                                                            ///< m2 / s
    return conductivity_w_m_k / (density_kg_m3 * heat_capacity_j_kg_k);
  }
};

struct Adiabatic {};
struct FixedTemperature {};
struct InnerFilm {
  double h_w_m2_k = 0.0;
};
struct InnerFlux {};
struct Sheet {
  double emissivity = 0.9;
  Convection convection = McAdams{};
  double wet_fraction = 0.0;
};
using Inside = std::variant<Adiabatic, FixedTemperature, InnerFilm, InnerFlux, Sheet>;

struct Construction {
  std::vector<Layer> layers;  ///< outside first
  double emissivity = 0.9;    ///< of the outer surface, its Planck mean
  Convection convection = McAdams{};
  Inside inside = Adiabatic{};
  double wet_fraction = 0.0;          ///< of the outer surface, that evaporates (surface_loss.h)
  double air_pressure_pa = 101325.0;  ///< of evaporation alone
  bool generates = false;             ///< layers generate heat, as ForcingValues::source_w_m3 says

  /// Whether any side evaporates.
  bool is_wet() const {
    const auto* sheet = std::get_if<Sheet>(&inside);
    return wet_fraction > 0.0 || (sheet != nullptr && sheet->wet_fraction > 0.0);
  }
  bool is_sheet() const { return std::holds_alternative<Sheet>(inside); }
};

/// Throws UsageError that begins with `where` and names the value: a layer whose conductivity, density, heat capacity
/// or thickness is not above 0 and finite, an emissivity or a wet fraction outside 0 ... 1, no layer, a negative film,
/// an outer surface that is wet and has no film.
void require_valid(const Construction& construction, std::string_view where);

/// Thermal resistance of all layers, m2 K / W, and their heat capacity, J / m2 / K.
double resistance(const Construction& construction);
double capacity(const Construction& construction);

/// sqrt(k d / h): facets much smaller than this exchange heat along the surface, which is not modelled. k d is summed
/// over the layers; `loss_w_m2_k` is h + 4 epsilon sigma T^3.
double in_plane_length_m(const Construction& construction, double loss_w_m2_k);

// Constant heat sources q(x) in the layers, W/m3, as heat at the surfaces. The temperature is the sum T = theta + S of
//   S       steady, (k S')' = -q, S = 0 at the exposed surfaces; inside it has no flow (adiabatic, flux), or gives
//           h S to a film, or is 0 at a fixed temperature
//   theta   without sources, with the heat that S brings to the surfaces added to what they absorb
// S is 0 at the surfaces, so theta is the temperature there at all times, exactly: nothing of the solver changes. Of a
// source at a depth the part R' / R comes out of the front, R' the resistance from there to where S is 0 inside, R that
// of the whole way; all of it where no heat passes inside. A source that changes with time would move S: then the
// solver has the sources of all layers at its nodes (Construction::generates, ForcingValues::source_w_m3).

/// What a film or a fixed temperature takes is in neither; the back is that of sheets.
struct SourceHeat {
  double front_w_m2 = 0.0, back_w_m2 = 0.0;
};
/// `source_w_m3`: of each layer.
SourceHeat source_heat(const Construction& construction, std::span<const double> source_w_m3);

}  // namespace radiometry::heat
