// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/otf_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "mtf/error.h"
#include "mtf/words.h"

namespace apps {
namespace {

using mtf::Axis;
using mtf::Complex;
using mtf::Entry;
using mtf::Freq;
using mtf::System;

constexpr double kMaxCyMm = 1e9;

/// Exact at the multiples of 90 degrees, where sine and cosine would leave 6e-17 of the other axis.
Freq<double> unit_vector(double angle_deg) {
  const double quarter = std::fmod(angle_deg, 360.0) / 90.0;
  const double whole = std::round(quarter);
  const double rest = (quarter - whole) * std::numbers::pi / 2.0;
  const double c = std::cos(rest), s = std::sin(rest);
  switch ((static_cast<int>(whole) + 8) % 4) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case 2:
      return {-c, -s};
    default:
      return {s, -c};
  }
}

void require_finite(const OtfColumn& column) {
  for (const Complex<double>& h : column.otf)
    if (!std::isfinite(h.re) || !std::isfinite(h.im))
      throw mtf::RuntimeError(column.label + ": its OTF is not a number at one of the frequencies; ask for lower ones");
}

}  // namespace

Direction make_direction(const mtf::Frame<double>& frame, const std::string& unit, double angle_deg) {
  if (!(std::abs(angle_deg) <= 360.0))
    throw mtf::UsageError("angle: " + mtf::format_double(angle_deg) + " is outside -360 to 360 degrees");
  if (unit != "cy/mm" && unit != "cy/mrad" && unit != "cy/px")
    throw mtf::UsageError("unit: '" + unit + "' is not known (one of cy/mm, cy/mrad, cy/px)");
  Freq<double> step = unit_vector(angle_deg);
  if (unit == "cy/mrad") step = {frame.cy_mm_from_mrad(step.x), frame.cy_mm_from_mrad(step.y)};
  if (unit == "cy/px") step = {frame.cy_mm_from_px(step.x, Axis::x), frame.cy_mm_from_px(step.y, Axis::y)};
  return {unit, angle_deg, step};
}

double KeyFigures::last_frequency() const { return std::min(cutoff.value_or(2.0 * nyquist), 2.0 * nyquist); }

bool OtfColumn::has_coarse_average() const {
  return std::any_of(error.begin(), error.end(), [](double e) { return !(e <= mtf::kBandError); });
}

std::vector<const OtfColumn*> OtfCurves::columns() const {
  std::vector<const OtfColumn*> shown;
  for (const OtfColumn& column : components) shown.push_back(&column);
  for (const OtfColumn& product : stages) {
    const bool any = std::any_of(components.begin(), components.end(),
                                 [&](const OtfColumn& column) { return column.stage == product.stage; });
    if (any || product.stage == "presample") shown.push_back(&product);
  }
  shown.push_back(&system);
  return shown;
}

mtf::System<double> system_at(const mtf::System<double>& system, const mtf::FieldPoint<double>& q) {
  constexpr double kFarthest = 4.0;
  if (!(std::hypot(q.x, q.y) <= kFarthest))
    throw mtf::UsageError("the field point (" + mtf::significant(q.x, 3) + ", " + mtf::significant(q.y, 3) + ") lies " +
                          mtf::significant(std::hypot(q.x, q.y), 3) +
                          " half diagonals from the axis; the corners of the detector lie about 1 from it");
  mtf::System<double> here = system.at(q);
  mtf::require_valid(here);
  return here;
}

KeyFigures key_figures(const System<double>& system, const Direction& direction) {
  const Freq<double>& step = direction.step;
  const double length = std::hypot(step.x, step.y);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  KeyFigures figures;
  figures.nyquist = std::min(step.x != 0.0 ? system.frame.nyquist_cy_mm(Axis::x) / std::abs(step.x) : infinity,
                             step.y != 0.0 ? system.frame.nyquist_cy_mm(Axis::y) / std::abs(step.y) : infinity);
  const auto shortest = system.band ? system.context(system.band->lo_um) : system.context();
  double cutoff = infinity;
  for (const Entry<double>& entry : system.list(mtf::Stage::presample)) {
    cutoff = std::min(cutoff, entry.component.cutoff_cy_mm(shortest));
    if (entry.component.is_pupil())
      figures.q = 2.0 * figures.nyquist * length / entry.component.cutoff_cy_mm(system.context());
  }
  if (std::isfinite(cutoff)) figures.cutoff = cutoff / length;
  return figures;
}

OtfCurves otf_curves(const System<double>& system, std::vector<double> frequency, const Direction& direction) {
  const KeyFigures figures = key_figures(system, direction);
  if (frequency.empty()) frequency = evenly_spaced(0.0, figures.last_frequency(), 61);
  std::vector<Freq<double>> f;
  f.reserve(frequency.size());
  for (const double value : frequency) {
    f.push_back({value * direction.step.x, value * direction.step.y});
    if (!(std::hypot(f.back().x, f.back().y) <= kMaxCyMm))
      throw mtf::UsageError("frequency: " + mtf::format_double(value) + " " + direction.unit + " is beyond 1e9 cy/mm");
  }
  OtfCurves values;
  values.name = system.name;
  values.direction = direction;
  values.figures = figures;
  values.frequency = std::move(frequency);
  values.system = {"system",
                   "",
                   "system",
                   true,
                   std::vector<Complex<double>>(f.size(), {1.0, 0.0}),
                   std::vector<double>(f.size(), 0.0)};
  for (const mtf::Stage stage : mtf::kStages) {
    const auto& list = system.list(stage);
    const std::string name(mtf::stage_name(stage));
    bool real = true;
    for (const Entry<double>& entry : list) {
      const bool own = entry.component.traits(system.context()).real;
      real = real && own;
      mtf::Averaged<double> otf = system.otf_with_error(std::span(&entry, 1), f);
      values.components.push_back(
          {entry.label, std::string(entry.component.kind()), name, own, std::move(otf.value), std::move(otf.error)});
      values.components.back().doc = entry.component.description();
      require_finite(values.components.back());
    }
    mtf::Averaged<double> otf = system.otf_with_error(std::span(list), f);
    values.stages.push_back({name, "", name, real, std::move(otf.value), std::move(otf.error)});
    require_finite(values.stages.back());
    values.system.real = values.system.real && real;
    const OtfColumn& product = values.stages.back();
    for (std::size_t i = 0; i < f.size(); ++i) {
      Complex<double>& h = values.system.otf[i];
      values.system.error[i] = values.system.error[i] * std::hypot(product.otf[i].re, product.otf[i].im) +
                               product.error[i] * std::hypot(h.re, h.im);
      h = h * product.otf[i];
    }
  }
  require_finite(values.system);
  return values;
}

std::optional<double> mtf50(const System<double>& system, const OtfCurves& curves) {
  const auto mtf_at = [](const OtfCurves& at, std::size_t i) {
    return std::hypot(at.system.otf[i].re, at.system.otf[i].im);
  };
  const auto first_below = [&](const OtfCurves& at) {
    std::size_t i = 0;
    while (i < at.frequency.size() && mtf_at(at, i) > 0.5) ++i;
    return i;
  };
  const std::size_t i = first_below(curves);
  if (i == 0 || i == curves.frequency.size()) return std::nullopt;
  const OtfCurves near =
      otf_curves(system, evenly_spaced(curves.frequency[i - 1], curves.frequency[i], 33), curves.direction);
  const std::size_t k = first_below(near);
  const double above = mtf_at(near, k - 1);
  return std::lerp(near.frequency[k - 1], near.frequency[k], (above - 0.5) / (above - mtf_at(near, k)));
}

std::vector<TableColumn> table_of(const OtfCurves& curves) {
  std::vector<TableColumn> table{{"frequency", curves.frequency}};
  const auto add = [&](std::string name, const OtfColumn& column, double Complex<double>::*part) {
    TableColumn& added = table.emplace_back(TableColumn{std::move(name), {}});
    // + 0.0 makes 0 of the negative zero, which would be printed as -0.
    for (const Complex<double>& h : column.otf) added.values.push_back(h.*part + 0.0);
  };
  for (const OtfColumn* column : curves.columns()) {
    add(column->real ? column->label : column->label + "_re", *column, &Complex<double>::re);
    if (!column->real) add(column->label + "_im", *column, &Complex<double>::im);
    if (column->has_coarse_average()) table.push_back({column->label + "_error", column->error});
  }
  return table;
}

std::vector<double> evenly_spaced(double start, double stop, int count) {
  std::vector<double> values(static_cast<std::size_t>(count), start);
  for (int i = 1; i < count; ++i)
    // Halves: the difference of two huge ends may overflow, and a product would round where the quotient is exact.
    values[static_cast<std::size_t>(i)] =
        i + 1 == count ? stop : start + 2.0 * ((0.5 * stop - 0.5 * start) * i / (count - 1));
  return values;
}

}  // namespace apps
