// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the models of a heat balance do not hold for, as a run meets it: winds that a closure of convection was not made
// for, wet surfaces that are colder or hotter than the formula of saturation. Each is said once, with the first time
// and place and the extreme.

#include <map>
#include <string>
#include <vector>

#include "radiometry/thermal/run/solve_units.h"

namespace radiometry::thermal {

/// Of the weather, for the closures of the materials.
std::vector<std::string> wind_limits(const ThermalScene& scene, const Surroundings& surroundings);

/// Of the temperatures of wet surfaces, output by output.
class SurfaceLimits {
 public:
  explicit SurfaceLimits(const HeatScene& scene);
  void see(const HeatOutput& output);
  std::vector<std::string> texts() const;

 private:
  const HeatScene& scene_;
  std::vector<std::uint32_t> wet_;  ///< facets
  std::map<std::uint32_t, heat::Beyond> of_region_;
};

}  // namespace radiometry::thermal
