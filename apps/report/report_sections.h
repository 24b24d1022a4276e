// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sections of a report as HTML, each complete without scripts.

#include <string>
#include <vector>

#include "apps/report/report_designs.h"
#include "apps/report/report_sweep.h"

namespace apps {

/// Axes, constraints, objectives and the best designs.
std::string summary_section(const Sweep& sweep, const DesignTable& table);
/// All designs: scatter, parallel coordinates, filters; which of them the page holds.
std::string trade_section(const Sweep& sweep, const DesignTable& table);
/// A metric over two axes.
std::string map_section(const Sweep& sweep);
/// The chosen designs side by side: values, curves, budgets, images. `scene`: the file of the images, "" for the
/// built-in one.
std::string chosen_section(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen,
                           const std::string& scene);
std::string sensitivity_section(const Sweep& sweep, const DesignTable& table);
/// Error against time, what was skipped.
std::string run_section(const Sweep& sweep);
/// Definition, unit and source of every column.
std::string columns_section(const Sweep& sweep);
/// The study and sensor files as text, versions and hashes.
std::string files_section(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen);

/// "name" with its definition on hovering, "name (unit)" for axes of charts.
std::string column_html(const SweepColumn& column);
std::string column_label(const SweepColumn& column);

/// Values of a column at every row of the table, NaN where a cell is empty or no number.
std::vector<double> column_values(const DesignTable& table, std::size_t column);

}  // namespace apps
