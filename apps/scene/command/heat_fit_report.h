// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fit of the ground as table, JSON and figure.

#include <string>

#include "apps/figures/plot.h"
#include "apps/scene/fit/heat_fit.h"

namespace apps::scene {

std::string heat_fit_table(const HeatFit& fit);
/// As that of `mtf fit`, with temperatures in place of the MTF.
std::string heat_fit_json(const SceneFile& scene, const HeatFit& fit);
/// Measured, solved with the numbers of the file, and fitted; the residuals.
std::vector<Figure> heat_fit_figures(const SceneFile& scene, const HeatFit& fit);

}  // namespace apps::scene
