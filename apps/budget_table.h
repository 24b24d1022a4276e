// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of `mtf budget`.

#include <string>
#include <vector>

#include "apps/sensor/sensor_chain.h"
#include "radiometry/performance/sensitivity.h"

namespace apps {

struct Figure;  // apps/figures/plot.h

struct BudgetTable {
  std::vector<radiometry::BudgetRow> rows;
  radiometry::Budget<double> numbers;  ///< that the rows are made of
  std::vector<std::string> notes;      ///< about the numbers
  std::vector<std::string> observer;   ///< who the observer of MRTD and MDTD is, and what air lies before the sensor
  std::string spatial_gap;             ///< why spatial noise has no number; "" where it has
  std::string air;                     ///< the table that gives the air that the sensor looks through; "" without air
  bool without_path = false;           ///< the scene gives the range of each pixel
};

/// For a surface of that temperature. `loaded`: the chain of `config`. Throws UsageError with the place in the file.
BudgetTable budget_table(const mtf::io::SensorConfig& config, const LoadedSensor& loaded, double temperature_k);

/// MRTD against the frequency of bars and MDTD against the size of a square, before a surface of that temperature.
/// Throws UsageError where the sensor has none.
std::vector<Figure> minimum_temperature_figures(const mtf::io::SensorConfig& config, double temperature_k);

/// Rows for people: in groups, those of the value 0 only named, then the largest terms in words. `rows`: those of the
/// budget, and others.
std::string budget_text(const BudgetTable& budget, const std::vector<radiometry::BudgetRow>& rows);

}  // namespace apps
