// SPDX-License-Identifier: Apache-2.0
#pragma once

// The folder that `mtf heat` writes:
//   times.csv             output, time (UTC), seconds from the start
//   regions.csv           time, region, least, mean (by area) and largest temperature
//   facets.csv            facet, mesh, region, material, area, centre, normal
//   temperatures.npy      float32, output times x facets, K; the front of sheets
//   temperatures_back.npy where there are sheets: their back, NaN for other facets
//   heat.json             closures, classes, steps, promise, residuals, times
// Every file appears whole or not at all.

#include <memory>
#include <string>
#include <vector>

#include "apps/scene/heat/heat_run.h"
#include "apps/scene/outputs/npy_file.h"

namespace apps::scene {

/// Least, mean by area and largest temperature of a region at an output.
struct RegionTemperature {
  double least_k = 0.0, mean_k = 0.0, most_k = 0.0;
};

class HeatFiles {
 public:
  HeatFiles(std::string folder, const HeatScene& scene);

  void append(const HeatOutput& output);
  /// All files appear.
  void commit(const HeatReport& report, const HeatOptions& options);

  /// [output][region]
  const std::vector<std::vector<RegionTemperature>>& regions() const { return regions_; }
  const std::vector<double>& times_s() const { return times_s_; }

 private:
  std::string at(const std::string& name) const { return folder_ + "/" + name; }
  std::string instant(double time_s) const;
  std::string facets_csv() const;

  std::string folder_;
  const HeatScene& scene_;
  std::vector<double> region_area_m2_;
  std::unique_ptr<NpyFile> front_, back_;
  std::vector<double> times_s_;
  std::vector<std::vector<RegionTemperature>> regions_;
};

/// heat.json
std::string heat_json(const HeatScene& scene, const HeatReport& report, const HeatOptions& options);

}  // namespace apps::scene
