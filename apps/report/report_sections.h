// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sections of a report as HTML, each complete without scripts.

#include <string>
#include <vector>

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

/// "name" with its definition on hovering.
std::string column_html(const SweepColumn& column);

}  // namespace apps
