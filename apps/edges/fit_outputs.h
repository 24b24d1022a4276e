// SPDX-License-Identifier: Apache-2.0
#pragma once

// The result of a fit as table, JSON, figure and sensor file.

#include <string>
#include <vector>

#include "apps/edges/measure_report.h"
#include "calib/fit/fit.h"
#include "mtf/io/config/config.h"

namespace apps {

std::string fit_table(const calib::FitResult& result);
std::string fit_json(const calib::FitResult& result, const mtf::io::SensorConfig& sensor,
                     const std::vector<std::string>& inputs);

/// MTF of the fitted system with its band beside the measured ones, and their difference.
std::vector<Figure> fit_figures(const calib::FitResult& result, const std::vector<MeasuredEdge>& measured);

/// The sensor file with the fitted values, their standard errors and where they come from. What the data do not
/// determine has the values of the best fit, so that the file gives the measured MTF, but no standard error.
std::string fitted_config(const calib::FitResult& result, const mtf::io::SensorConfig& sensor,
                          const std::vector<std::string>& inputs, const std::string& destination);

}  // namespace apps
