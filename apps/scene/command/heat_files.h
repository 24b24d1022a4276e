// SPDX-License-Identifier: Apache-2.0
#pragma once

// The folder that `mtf heat` writes:
//   times.csv             output, time (UTC), seconds from the start
//   regions.csv           time, region, least, mean (by area) and largest temperature of the facets that are asked for,
//                         empty where there is none
//   facets.csv            facet, mesh, region, material, area, centre, normal
//   temperatures.npy      float32, output times x facets, K; the front of sheets; NaN where it is not asked for
//   temperatures_back.npy where there are sheets: their back, NaN for other facets
//   heat.json             closures, classes, steps, promise, residuals, times
// and, while it is not finished, unfinished.bin, unfinished.npy and, with sheets, unfinished_back.npy.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/outputs/npy_file.h"

namespace apps::scene {

/// Least, mean by area and largest temperature of a region at an output.
struct RegionTemperature {
  double least_k = 0.0, mean_k = 0.0, most_k = 0.0;
};

/// Of all regions, from temperatures of facets, of which NaN are not asked for; NaN for a region without any.
std::vector<RegionTemperature> region_temperatures(const HeatScene& scene, std::span<const double> facet_k);

/// Of the outputs that a run had when it was interrupted, or kept before it was killed.
struct EarlierOutputs {
  std::vector<double> times_s;
  std::vector<std::vector<RegionTemperature>> regions;  ///< [output][region]
};

class HeatFiles {
 public:
  /// Files are written into `folder`; what is kept of a run that is not finished stands in `kept`.
  HeatFiles(std::string folder, std::string kept, const SceneFile& file, const HeatScene& scene);

  /// The outputs that stand in the folder, before others are appended. Throws RuntimeError where its tables are not
  /// those of that many outputs.
  void take_over(const EarlierOutputs& earlier);

  void append(const HeatOutput& output);
  /// The outputs so far stand in unfinished*.npy, on the disk, and stay there when the process is killed. False where
  /// the file system does not allow that.
  bool keep();
  /// All files are written.
  void write(const HeatReport& report, const HeatOptions& options);

  /// [output][region]
  const std::vector<std::vector<RegionTemperature>>& regions() const { return regions_; }
  const std::vector<double>& times_s() const { return times_s_; }

 private:
  std::string at(const std::string& name) const { return folder_ + "/" + name; }
  std::string instant(double time_s) const;
  std::string facets_csv() const;

  std::string folder_, kept_;
  const SceneFile& file_;
  const HeatScene& scene_;
  std::unique_ptr<NpyFile> front_, back_;
  std::vector<double> times_s_;
  std::vector<std::vector<RegionTemperature>> regions_;
};

/// All names of files in the folder of a finished run.
std::vector<std::string> heat_names();

/// Facets inside other solids, by the names of their regions, without those that have none.
std::vector<std::pair<std::string, std::size_t>> covered_by_region(const HeatScene& scene, const HeatReport& report);

/// heat.json
std::string heat_json(const SceneFile& file, const HeatScene& scene, const HeatReport& report,
                      const HeatOptions& options);

// A `mtf heat` that is interrupted leaves the file unfinished.bin in its folder, and one that runs for long writes it
// every few seconds, so that one that is killed leaves it too. The outputs so far are in unfinished.npy and
// unfinished_back.npy, which hold at least those that unfinished.bin counts. The same command reads them and continues
// with the first day that is not finished. Only the program that wrote the files can read them. unfinished.bin holds
// the hashes of all inputs, by which a changed input is recognised and refused.

/// Names and hashes of all that the numbers of a run follow from: the scene file, meshes, weather, given temperatures,
/// options, the program.
using Fingerprints = std::vector<std::pair<std::string, std::string>>;
Fingerprints fingerprints_of(const SceneFile& file, const HeatScene& scene, const HeatOptions& options);

struct UnfinishedRun {
  Fingerprints fingerprints;
  EarlierOutputs outputs;
  Checkpoint checkpoint;
};

std::string unfinished_path(const std::string& folder);
/// All files of it: the state first, as without it the tables are no run.
std::vector<std::string> unfinished_files(const std::string& folder);

/// Whether there is one. Anything may stand in the folder, which may not exist.
bool is_unfinished(const std::string& folder);

/// When a run is finished. What it leaves then is still none or all of it.
void remove_unfinished(const std::string& folder);

/// The file appears whole or not at all.
void write_unfinished(const std::string& folder, const UnfinishedRun& run);

/// Of a scene of so many regions. Throws UsageError for a file that is damaged, and where an input is not what it was.
UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now, std::size_t regions);

}  // namespace apps::scene
