// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surfaces of a scene: meshes read and placed, their facets, and for each facet the region that it belongs to. A
// region has a material whose heat balance is solved, a given temperature, or both (then the material gives the
// emissivity).

#include <optional>
#include <string>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"
#include "radiometry/heat/construction.h"
#include "radiometry/scene/facets.h"

namespace apps::scene {

/// How a material absorbs and emits, and what lies below its surface.
struct Surface {
  std::string name;
  radiometry::heat::Construction construction;
  double solar_absorptance = 0.0, back_solar_absorptance = 0.0;
  /// Heat generated in the layers that comes out of the front and of the back, W/m2 (layer_sources.h).
  double source_w_m2 = 0.0, back_source_w_m2 = 0.0;
  /// Of each layer, W/m3, where one changes with time: then the solver has them and the two above are 0. Else empty.
  std::vector<radiometry::heat::Schedule> sources{};
  double pair_m = 0.0;                ///< inside.kind = "pair": the longest distance of opposite faces; else 0
  radiometry::heat::Schedule inside;  ///< K or W/m2, what the construction's inside asks for; empty: nothing

  double emissivity(bool back) const;
  double absorptance(bool back) const { return back ? back_solar_absorptance : solar_absorptance; }
};

struct Surfaces {
  radiometry::scene::Facets facets;
  std::vector<std::uint32_t> region;  ///< of each facet, an index into SceneFile::regions
  std::vector<Surface> material;      ///< those of the file, in its order
  std::vector<std::string> warnings;
};

/// The material of the file as the heat solver has it, in air of 1013.25 hPa. Throws UsageError, beginning with the
/// material's name, for what nothing determines the temperature of.
Surface surface_of(const MaterialSection& material);

/// Reads the meshes of the scene and finds the region of every facet. Throws UsageError for a face that no region has,
/// a region without faces, and what facets_of and import_mesh refuse.
Surfaces read_surfaces(const SceneFile& scene);

}  // namespace apps::scene
