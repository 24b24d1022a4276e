// SPDX-License-Identifier: Apache-2.0
#pragma once

// What gnuplot is told to draw figures: data, axes, legends, colours and symbols.

#include <array>
#include <span>
#include <string>

#include "apps/figures/plot.h"

namespace apps {

enum class Medium { svg, pdf, png, characters };

/// Of the figure's x axis. Throws UsageError where the figure has no point that can be drawn.
std::array<double, 2> x_range(const Figure& figure);

/// Figures side by side. `columns` and `rows` are the size of a drawing in characters.
std::string gnuplot_script(std::span<const Figure> figures, Medium medium, int columns = 0, int rows = 0);

}  // namespace apps
