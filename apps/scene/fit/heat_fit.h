// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of the ground's material fitted to measured temperatures of the ground: a level surface under the whole sky,
// solved by its heat balance with the day that repeats. Which numbers is said by the scene file, where they stand as
// tables { value, fit = true, min, max }. Every trial writes the numbers into the text of the file and reads it again,
// so that the fitted file means what was fitted.

#include <string>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"
#include "calib/series/series_fit.h"

namespace apps::scene {

/// What the temperature of the ground was, measured: a table of temperatures, or the long-wave radiation that a station
/// saw coming up. The ground emits epsilon sigma T^4 and reflects the rest of what the sky sends:
///   L_up = epsilon sigma T^4 + (1 - epsilon) L_down
/// Records that are means over an interval stand for its middle.
struct MeasuredSurface {
  std::string source;
  bool from_longwave = false;
  std::vector<double> time_s{};  ///< from the start of the run, rising
  std::vector<double> kelvin{};  ///< NaN where the record has no value
};

inline constexpr std::size_t kMostFitted = 6;

struct HeatFitOptions {
  double tolerance_k = 0.05;  ///< of a solution
  int threads = 0;
  std::function<void(int solutions)> progress{};
};

struct HeatFit {
  MeasuredSurface measured;
  calib::SeriesFit series;
  double correlation_time_s = 0.0;  ///< after which residuals are correlated by 1 / e
  std::vector<std::string> warnings;
};

/// Throws UsageError for a scene without a solved ground, no or too many numbers to fit, numbers that are not those of
/// the ground's material, and an emissivity that the measured temperatures depend on.
HeatFit fit_heat(const SceneFile& scene, const HeatFitOptions& options = {});

/// The text of the scene with the fitted values and their standard errors, and lines above that say where they come
/// from. What the data do not determine has the value of the best fit, and no standard error.
std::string fitted_scene_text(const SceneFile& scene, const HeatFit& fit);

}  // namespace apps::scene
