// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the temperatures depend on: the whole run again, with one thing changed at a time. Formulas of convection and
// sky and the numbers of materials are known to 10 % and less well, which is kelvins; a tolerance says nothing about
// that.

#include <functional>
#include <string>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"

namespace apps::scene {

/// Mean temperatures of regions by area, [output][region], as a run has them.
using RegionMeans = std::vector<std::vector<double>>;

/// How a change moves the mean temperature of a region.
struct RegionChange {
  double mean_k = 0.0;     ///< over the outputs
  double largest_k = 0.0;  ///< at the output where it is largest, with its sign
};

struct Sensitivity {
  std::string change;                 ///< "convection +10 %"
  std::vector<RegionChange> regions;  ///< as ThermalScene::regions
};

/// Six runs: convection, long wave of the sky, solar absorptance, emissivity, conductivity, heat capacity. `base`: of
/// the scene as it is. Changes below the promise of a run are rounding of its classes, steps and cells. Of tarp only
/// the part of the wind is changed.
std::vector<Sensitivity> sensitivities(HeatScene& scene, const HeatOptions& options, const RegionMeans& base,
                                       const std::function<void(const std::string& change, double share)>& progress);

std::string sensitivity_table(const HeatScene& scene, const std::vector<Sensitivity>& all);
/// change,region,mean_K,largest_K
std::string sensitivity_csv(const HeatScene& scene, const std::vector<Sensitivity>& all);

}  // namespace apps::scene
