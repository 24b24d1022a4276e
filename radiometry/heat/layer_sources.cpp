// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/layer_sources.h"

namespace radiometry::heat {

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
