// SPDX-License-Identifier: Apache-2.0
#pragma once

// `mtf budget --curves`: MRTD against the frequency of bars, MDTD against the size of a square, of the observer and the
// noise of `mtf budget` (budget_table.h). A row is a frequency and the square that is as wide as one of its bars,
// W = 1/(2 f). MRTD ends at the Nyquist frequency, MDTD goes on to squares of a quarter of a pixel.

#include <string>
#include <vector>

#include "apps/options.h"

namespace apps {

struct MinimumTemperatures {
  struct Row {
    double f_cy_mrad = 0.0, width_mrad = 0.0;
    double mrtd_x_k = 0.0, mrtd_y_k = 0.0, mrtd_k = 0.0, mdtd_k = 0.0;  ///< NaN: not resolved at any difference
    double mrtd_error = 0.0, mdtd_error = 0.0;  ///< relative, of the numbers: by what the OTF may err
  };
  std::vector<Row> rows;
  std::vector<std::string> observer;  ///< who looks, and what air lies before the sensor
};

int run_budget_curves(const BudgetOptions& options, const Global& global);

}  // namespace apps
