// SPDX-License-Identifier: Apache-2.0

// From the number of a design to the values of its axes.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "apps/study/statistics/sampling.h"
#include "apps/study/study.h"

namespace study {
namespace {

double between(const Axis& axis, double fraction) {
  if (fraction <= 0.0) return axis.from;
  if (fraction >= 1.0) return axis.to;
  const double value = axis.scale == Scale::log
                           ? std::exp((1.0 - fraction) * std::log(axis.from) + fraction * std::log(axis.to))
                           : axis.from * (1.0 - fraction) + axis.to * fraction;
  return std::clamp(value, std::min(axis.from, axis.to), std::max(axis.from, axis.to));
}

/// Point of a grid; of a discrete axis the index of its level.
double grid_value(const Axis& axis, std::int64_t i) {
  if (axis.discrete()) return static_cast<double>(i);
  if (!axis.values.empty()) return axis.values[static_cast<std::size_t>(i)];
  if (axis.count < 2) return axis.from;
  const double last = axis.count - 1, step = static_cast<double>(i);
  if (axis.scale == Scale::linear && 0.0 < step &&
      step < last) {  // round numbers stay round: 16 mm of 12 to 96 mm, not 15.999999999999998
    const double value = (axis.from * (last - step) + axis.to * step) / last;
    if (std::isfinite(value)) return value;
  }
  return between(axis, step / last);
}

double quantile(const Axis& axis, double u) {
  if (axis.values.empty()) return between(axis, u);
  const auto n = static_cast<std::int64_t>(axis.values.size());
  const auto i = static_cast<std::int64_t>(std::floor(std::clamp(u, 0.0, 1.0) * static_cast<double>(n)));
  return grid_value(axis, std::min(i, n - 1));
}

}  // namespace

void design_at(const Study& study, std::int64_t design, std::span<double> axis_values) {
  assert(axis_values.size() == study.axes.size() && design >= 0 && design < study.designs);
  const auto i = static_cast<std::uint64_t>(design), n = static_cast<std::uint64_t>(study.designs);
  if (study.method == Method::grid) {
    for (std::size_t a = study.axes.size(); a-- > 0;) {
      const Axis& axis = study.axes[a];
      const std::int64_t points = axis.points();
      axis_values[a] = grid_value(axis, design % points);
      design /= points;
    }
    return;
  }
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    const auto number = static_cast<std::uint32_t>(a);
    const double u = study.method == Method::sobol ? sobol(study.sobol[a], i, number, study.seed)
                                                   : latin_hypercube(i, n, number, study.seed);
    axis_values[a] = quantile(study.axes[a], u);
  }
}

void design_at_quantiles(const Study& study, std::span<const double> unit, std::span<double> axis_values) {
  assert(unit.size() == study.axes.size() && axis_values.size() == study.axes.size());
  for (std::size_t a = 0; a < study.axes.size(); ++a) axis_values[a] = quantile(study.axes[a], unit[a]);
}

}  // namespace study
