// SPDX-License-Identifier: Apache-2.0
#pragma once

// Static charts of a report as SVG: shown where scripts do not run, and in builds without the chart libraries.
// Colours come from the page's style sheet, so they follow its light, dark and printed form.

#include <array>
#include <optional>
#include <span>
#include <string>

#include "apps/figures/plot.h"

namespace apps {

/// Lines and points of a figure of plot.h, with axes, ticks and a legend. What is not finite, or not positive on a log
/// axis, is left out.
std::string svg_figure(const Figure& figure);

/// Ends of the axis of bars, which are clipped there, or of a whisker.
using Ends = std::array<double, 2>;

struct Bar {
  std::string label;
  double value = 0.0, spread = 0.0;  ///< with a whisker where the spread is above 0
  std::optional<Ends> interval{};    ///< of the whisker, where it is not value +- spread
};

/// Horizontal bars from 0.
std::string svg_bars(const std::string& title, const std::string& x_label, std::span<const Bar> bars,
                     std::optional<Ends> ends = {});

}  // namespace apps
