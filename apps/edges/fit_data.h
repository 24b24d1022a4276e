// SPDX-License-Identifier: Apache-2.0
#pragma once

// The inputs of `mtf fit`, loaded: images and their measured edges, curves, spots, and the sensor of each.

#include <list>
#include <string>
#include <vector>

#include "apps/edges/edge_input.h"
#include "apps/edges/measure_report.h"
#include "calib/fit/fit.h"
#include "mtf/io/config/config.h"

namespace apps {

struct LoadedData {
  calib::FitData data;                 ///< refers to `planes`
  std::list<EdgePlane> planes;         ///< stay where they are
  std::vector<MeasuredEdge> measured;  ///< one for each edge of `data`
  std::vector<std::string> files;      ///< that hold the data, for provenance
  std::vector<std::string> warnings;   ///< what was left out, and why
  std::size_t left_out = 0;            ///< files that could not be read
};

/// "FILE@DEGREES" or "FILE" of --curve.
struct CurveWord {
  std::string file;
  double angle_deg = 0.0;
};
CurveWord curve_word(const std::string& word);

/// Numbers that the sensor file marks fit = true. Throws UsageError when there is none.
std::vector<calib::FitParameter> fit_parameters(const mtf::io::SensorConfig& sensor);

/// Measures the edges of a plane and adds them. `condition`: index of the sensor it was taken with, of
/// FitData::conditions.
void add_edges(LoadedData& loaded, EdgePlane plane, std::size_t condition, int threads);
/// Adds a plane as the image of a point source.
void add_spot(LoadedData& loaded, EdgePlane plane, std::size_t condition);

/// Loads and measures. One of several that cannot be read is left out with a warning. Throws as load_edge_planes.
LoadedData load_fit_data(const FitOptions& options, const mtf::io::SensorConfig& sensor, int threads);

}  // namespace apps
