// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/curve_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "mtf/error.h"

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
    throw mtf::UsageError("--angle: " + mtf::format_double(angle_deg) + " is outside -360 to 360 degrees");
  Freq<double> step = unit_vector(angle_deg);
  if (unit == "cy/mrad") step = {frame.cy_mm_from_mrad(step.x), frame.cy_mm_from_mrad(step.y)};
  if (unit == "cy/px") step = {frame.cy_mm_from_px(step.x, Axis::x), frame.cy_mm_from_px(step.y, Axis::y)};
  return {unit, angle_deg, step};
}

bool has_coarse_average(const OtfColumn& column) {
  return std::any_of(column.error.begin(), column.error.end(), [](double e) { return !(e <= mtf::kBandError); });
}

CurveValues curve_values(const System<double>& system, const Direction& direction, std::vector<double> frequency) {
  std::vector<Freq<double>> f;
  f.reserve(frequency.size());
  for (const double value : frequency) {
    f.push_back({value * direction.step.x, value * direction.step.y});
    if (!(std::hypot(f.back().x, f.back().y) <= kMaxCyMm))
      throw mtf::UsageError("--freq: " + mtf::format_double(value) + " " + direction.unit + " is beyond 1e9 cy/mm");
  }
  CurveValues values;
  values.direction = direction;
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

}  // namespace apps
