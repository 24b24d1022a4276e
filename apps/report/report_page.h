// SPDX-License-Identifier: Apache-2.0
#pragma once

// The whole report as one page that needs nothing else: style, scripts, data and pictures are in it.

#include <string>
#include <vector>

#include "apps/report/report_chosen.h"
#include "apps/report/report_designs.h"
#include "apps/report/report_sweep.h"

namespace apps {

/// What the page's script reads: columns, designs with their cells as in designs.csv, curves. JSON in which no text
/// ends a script element.
std::string report_data(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen);

/// `scene`: the file of the images, "" for the built-in one. Its policy allows the page's own scripts only, by their
/// hashes.
std::string report_page(const Sweep& sweep, const DesignTable& table, const std::vector<ChosenDesign>& chosen,
                        const std::string& scene);

}  // namespace apps
