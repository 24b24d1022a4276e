// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf fit`: its data, loaded (images and their measured edges, curves, spots, and the sensor of each), and the result
// as table, JSON and sensor file.

#include <list>
#include <set>
#include <string>
#include <vector>

#include "apps/edges/edge_input.h"
#include "apps/edges/measure_report.h"
#include "apps/text/json.h"
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
  std::set<std::string> seen;          ///< places of the data so far: file, and region in it
};

/// Numbers that the sensor file marks fit = true. Throws UsageError when there is none.
std::vector<calib::FitParameter> fit_parameters(const mtf::io::SensorConfig& sensor);

/// Measures the edges of a plane and adds them. `condition`: index of the sensor it was taken with, of
/// FitData::conditions.
void add_edges(LoadedData& loaded, EdgePlane plane, std::size_t condition, int threads);
/// Adds a plane as the image of a point source.
void add_spot(LoadedData& loaded, EdgePlane plane, std::size_t condition);

std::string fit_table(const calib::FitResult& result);
Json fit_report(const calib::FitResult& result, const mtf::io::SensorConfig& sensor,
                const std::vector<std::string>& inputs);

/// The sensor file with the fitted values, their standard errors and where they come from. What the data do not
/// determine has the values of the best fit, so that the file gives the measured MTF, but no standard error.
std::string fitted_config(const calib::FitResult& result, const mtf::io::SensorConfig& sensor,
                          const std::vector<std::string>& inputs, const std::string& destination);

}  // namespace apps
