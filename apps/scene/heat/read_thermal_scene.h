// SPDX-License-Identifier: Apache-2.0
#pragma once

// From a scene file to the plain values of its heat balance (thermal_scene.h): what stands in the file, then, each by
// itself since not everyone needs it, the weather, the meshes and the tables of single facets that it names.

#include "apps/scene/scene_file/scene_file.h"
#include "radiometry/thermal/run/heat_run.h"

namespace apps::scene {

using namespace radiometry::thermal;  // scenes as values, their heat balance, its report

/// The material of the file, in air of that pressure. Throws as require_valid of a material.
Material material_of(const MaterialSection& material, double air_pressure_pa);

/// All that stands in the file: place, times, materials, regions, ground and camera. Throws UsageError as material_of,
/// and for a ground with a table of facets.
ThermalScene values_of(const SceneFile& file);

/// Weather and sky. Throws as scene_weather, clear_sky_of and require_weather.
void read_scene_weather(const SceneFile& file, ThermalScene& scene);

/// Facets and the region of each. Throws UsageError for a face that no region has, a region without faces, and what
/// facets_of and import_mesh refuse.
void read_meshes(const SceneFile& file, ThermalScene& scene);

/// The tables of regions, once there are facets. Throws as read_temperatures.
void read_tables(const SceneFile& file, ThermalScene& scene);

/// What all surfaces of the file share over time; meshes are not read.
Surroundings surroundings_of(const SceneFile& file, int directions, double tolerance_k);

/// All of it, ready for its heat balance.
HeatScene prepare_heat(const SceneFile& file, const HeatOptions& options);

}  // namespace apps::scene
