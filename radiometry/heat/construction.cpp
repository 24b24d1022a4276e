// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/construction.h"

#include <cmath>

#include "mtf/error.h"
#include "mtf/units.h"

namespace radiometry::heat {
namespace {

[[noreturn]] void refuse(std::string_view where, const std::string& name, double value, const char* rule) {
  throw mtf::UsageError(std::string(where) + ": " + name + " is " + mtf::format_double(value) + ", has to be " + rule);
}

void require_fraction(double value, std::string_view where, const std::string& name) {
  if (!(value >= 0.0 && value <= 1.0)) refuse(where, name, value, "between 0 and 1");
}

/// Vapour goes with the heat that the film carries (surface_loss.h).
void require_film(double wet_fraction, const Convection& convection, std::string_view where) {
  if (wet_fraction > 0.0 && forced_coefficient(convection, 1.0) == 0.0)
    throw mtf::UsageError(std::string(where) +
                          ": wet_fraction without a film: water evaporates into the air that takes heat, and this "
                          "convection takes none; give a convection, or leave wet_fraction out");
}

}  // namespace

void require_valid(const Construction& construction, std::string_view where) {
  if (construction.layers.empty())
    throw mtf::UsageError(std::string(where) + ": a construction without layers, give at least one");
  for (std::size_t i = 0; i < construction.layers.size(); ++i) {
    const Layer& layer = construction.layers[i];
    const std::string prefix = "layers[" + std::to_string(i) + "] ";
    for (const auto& [name, value] : {std::pair{"conductivity (W/m/K)", layer.conductivity_w_m_k},
                                      std::pair{"density (kg/m3)", layer.density_kg_m3},
                                      std::pair{"heat_capacity (J/kg/K)", layer.heat_capacity_j_kg_k},
                                      std::pair{"thickness (m)", layer.thickness_m}})
      if (!(value > 0.0) || !std::isfinite(value)) refuse(where, prefix + name, value, "above 0");
  }
  require_fraction(construction.emissivity, where, "emissivity");
  require_fraction(construction.wet_fraction, where, "wet fraction");
  if (construction.is_wet() && !(construction.air_pressure_pa > 0.0 && std::isfinite(construction.air_pressure_pa)))
    refuse(where, "air pressure (Pa)", construction.air_pressure_pa, "above 0");
  require_valid(construction.convection, where);
  require_film(construction.wet_fraction, construction.convection, where);
  if (const auto* film = std::get_if<InnerFilm>(&construction.inside)) {
    if (!(film->h_w_m2_k >= 0.0) || !std::isfinite(film->h_w_m2_k))
      refuse(where, "inside h (W/m2/K)", film->h_w_m2_k, "a number that is not negative");
  } else if (const auto* sheet = std::get_if<Sheet>(&construction.inside)) {
    require_fraction(sheet->emissivity, where, "inside emissivity");
    require_fraction(sheet->wet_fraction, where, "inside wet fraction");
    require_valid(sheet->convection, std::string(where) + ": inside");
    require_film(sheet->wet_fraction, sheet->convection, std::string(where) + ": inside");
  }
}

double resistance(const Construction& construction) {
  double sum = 0.0;
  for (const Layer& layer : construction.layers) sum += layer.resistance();
  return sum;
}

double capacity(const Construction& construction) {
  double sum = 0.0;
  for (const Layer& layer : construction.layers) sum += layer.capacity();
  return sum;
}

double in_plane_length_m(const Construction& construction, double loss_w_m2_k) {
  double sum = 0.0;
  for (const Layer& layer : construction.layers) sum += layer.conductivity_w_m_k * layer.thickness_m;
  return std::sqrt(sum / loss_w_m2_k);
}

SourceHeat source_heat(const Construction& construction, std::span<const double> source_w_m3) {
  const auto* film = std::get_if<InnerFilm>(&construction.inside);
  const bool held = construction.is_sheet() || std::holds_alternative<FixedTemperature>(construction.inside) ||
                    (film != nullptr && film->h_w_m2_k > 0.0);
  const double whole = resistance(construction) + (film != nullptr && held ? 1.0 / film->h_w_m2_k : 0.0);
  SourceHeat heat;
  double before = 0.0;
  for (std::size_t i = 0; i < construction.layers.size(); ++i) {
    const Layer& layer = construction.layers[i];
    const double generated = source_w_m3[i] * layer.thickness_m;
    // Uniform in the layer: as if at its middle.
    const double inwards = held ? (before + 0.5 * layer.resistance()) / whole : 0.0;
    heat.front_w_m2 += (1.0 - inwards) * generated;
    if (construction.is_sheet()) heat.back_w_m2 += inwards * generated;
    before += layer.resistance();
  }
  return heat;
}

}  // namespace radiometry::heat
