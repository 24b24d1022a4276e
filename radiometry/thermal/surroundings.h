// SPDX-License-Identifier: Apache-2.0
#pragma once

// What all surfaces of a scene share, as a table over time: air, wind, sun and sky. Between two nodes everything is a
// straight line but the direction to the sun, which turns about the earth's axis evenly: nodes are at most 10 minutes
// apart, within which that is right to 1e-7 rad. Nodes stand at the nodes of the weather, at the directions of the
// table of shadows, at outputs and at samples of schedules, and, closer and closer, after a jump of the sunlight: what
// surfaces give off then goes with the root of the time.

#include <vector>

#include "radiometry/scene/vectors.h"
#include "radiometry/thermal/thermal_scene.h"

namespace radiometry::thermal {

/// Nodes that follow the last one sooner are those after jumps.
inline constexpr double kUsualLag_s = 60.0;

/// Nodes that are so near to each other have a jump of the light between them.
constexpr bool is_jump(double begin_s, double end_s) { return end_s - begin_s < 5.0; }

struct Surroundings {
  std::vector<double> time_s;  ///< from the start of the run, strictly rising
  std::vector<double> air_k, wind_m_s;
  std::vector<double> vapour_pa;          ///< where it is asked for; else 0
  std::vector<double> direct_w_m2;        ///< on a plane that faces the sun; 0 while the sun is down
  std::vector<double> diffuse_w_m2;       ///< on a horizontal plane, without the beam
  std::vector<double> global_w_m2;        ///< on a horizontal plane: direct cos z + diffuse
  std::vector<double> sky_longwave_w_m2;  ///< on a horizontal plane
  std::vector<scene::Vector> to_sun;      ///< in the axes of the meshes
  scene::Vector pole{};                   ///< of the earth's axis
  std::vector<std::size_t> outputs;       ///< nodes that are outputs, the start included

  /// The table of shadows: directions to the sun, and for the interval after each node the entry of the table that it
  /// begins in; -1 where the sun is down. Entries are linear in time between neighbours.
  std::vector<double> shadow_time_s;
  std::vector<scene::Vector> shadow_to_sun;
  std::vector<int> shadow_entry;

  std::vector<std::string> warnings;

  std::size_t nodes() const { return time_s.size(); }
  /// The direction to the sun at a share of the interval after a node.
  scene::Vector sun_between(std::size_t node, double share) const;
};

/// Throws UsageError, with the remedy, for weather that does not cover the run and a day from its start, or lacks what
/// the balance and the sky take.
void require_weather(const ThermalScene& scene);

/// From the start of the run to its end, or to a day after the start where that is later: the first day is what the
/// start repeats. `directions` a day of the table of shadows; nodes are the denser the smaller the tolerance is. The
/// facets of the scene are not looked at. Throws as require_weather.
Surroundings surroundings_of(const ThermalScene& scene, int directions, double tolerance_k);

}  // namespace radiometry::thermal
