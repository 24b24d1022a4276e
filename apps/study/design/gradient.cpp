// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/gradient.h"

#include <cmath>

#include "apps/study/design/design_model.h"
#include "calib/fit/system_jet.h"
#include "mtf/error.h"

namespace mtf {
extern template class ResolutionMeter<calib::Jet4>;
}

namespace study {
namespace {

using calib::Jet4;
constexpr int kStride = 4;

/// Band integrals as jets: their values, and slopes by those of their numbers that carry derivatives.
radiometry::SpectralNumbers<Jet4> spectral_jets(const VariantSensor& variant, const Conditions& conditions,
                                                std::span<const radiometry::Override<Jet4>> overrides) {
  std::vector<radiometry::Override<double>> plain;
  for (const auto& o : overrides) plain.push_back({o.path, o.value.a});
  const auto at = [&] {
    return spectral_numbers(conditions, variant.loaded->sensor,
                            radiometry::Overrides<double>{std::span<const radiometry::Override<double>>(plain)});
  };
  radiometry::SpectralNumbers<double> here = at();
  radiometry::SpectralNumbers<Jet4> jets;
  const auto numbers = jets.all();
  const auto values = here.all();
  for (std::size_t n = 0; n < numbers.size(); ++n) *numbers[n] = Jet4(*values[n]);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    if (!radiometry::is_spectral(plain[i].path) || overrides[i].value.v.isZero()) continue;
    const double value = plain[i].value;
    // Inside of what is allowed, on one side where the value lies at the end of it: fractions stop at 0 and 1. The
    // slope of a band model at range 0 is infinite; the one at 1 m stands for it.
    const bool fraction = plain[i].path == "path.transmission" || plain[i].path == "scene.emissivity" ||
                          plain[i].path == "atmosphere.relative_humidity";
    const double least = plain[i].path == "atmosphere.range" ? 1.0 : 0.0;
    const double h = 1e-3 * std::max({std::abs(value), 1e-3, least});
    const double middle = fraction ? std::clamp(value, 2.0 * h, 1.0 - 2.0 * h) : std::max(value, least + 2.0 * h);
    std::array<radiometry::SpectralNumbers<double>, 4> around;
    constexpr std::array<double, 4> steps{-2.0, -1.0, 1.0, 2.0};
    for (std::size_t k = 0; k < steps.size(); ++k) {
      plain[i].value = middle + steps[k] * h;
      around[k] = at();
    }
    plain[i].value = value;
    for (std::size_t n = 0; n < numbers.size(); ++n) {
      const auto of = [&](std::size_t k) { return *around[k].all()[n]; };
      numbers[n]->v += (8.0 * (of(2) - of(1)) - (of(3) - of(0))) / (12.0 * h) * overrides[i].value.v;
    }
  }
  return jets;
}

}  // namespace

Gradient gradient_of(const Study& study, const VariantSensor& variant, std::span<const double> parameters,
                     double tolerance) {
  Gradient gradient;
  std::vector<std::size_t> axes;  // parameters of numeric axes
  for (const Axis& axis : study.axes)
    if (!axis.discrete()) axes.push_back(static_cast<std::size_t>(axis.parameter));
  for (const std::size_t i : axes) gradient.parameters.push_back(study.parameters[i].name);
  for (const MetricInfo& metric : study.metrics) gradient.columns.push_back(metric.name);
  for (const Objective& objective : study.objectives)
    if (!objective.expression.only_slot()) gradient.columns.push_back(objective.text);
  for (auto* values : {&gradient.value, &gradient.objective, &gradient.margin}) {
    const std::size_t rows = values == &gradient.value       ? gradient.columns.size()
                             : values == &gradient.objective ? study.objectives.size()
                                                             : study.constraints.size();
    values->assign(rows * axes.size(), std::numeric_limits<double>::quiet_NaN());
  }
  if (parameters.empty()) return gradient;

  const MetricPlan plan = plan_metrics(study, std::min(study.tolerance, tolerance));
  DesignModel<Jet4> model(study, plan, variant, mtf::cast<Jet4>(variant.system));
  for (std::size_t first = 0; first < axes.size(); first += kStride) {
    std::vector<Jet4> values(parameters.begin(), parameters.end()), slots(study.slots()), metrics(study.metrics.size());
    const std::size_t count = std::min<std::size_t>(kStride, axes.size() - first);
    for (std::size_t k = 0; k < count; ++k) values[axes[first + k]].v[static_cast<Eigen::Index>(k)] = 1.0;
    const auto slot = [&](std::size_t i) { slots[i] = values[i] * Jet4(study.parameters[i].scale.si); };
    for (std::size_t i = 0; i < values.size(); ++i) slot(i);
    for (const Link& link : study.links) {
      const auto i = static_cast<std::size_t>(link.parameter);
      values[i] = link.expression.evaluate<Jet4>(slots) / Jet4(study.parameters[i].scale.si);
      slot(i);
    }
    model.set(values);
    try {
      radiometry::SpectralNumbers<Jet4> spectral;
      if (plan.budget && variant.loaded) spectral = spectral_jets(variant, study.conditions, model.overrides());
      model.metrics(spectral, metrics);
    } catch (const mtf::UsageError&) {
      return gradient;  // as the row of this design: no metrics
    }
    for (std::size_t i = 0; i < metrics.size(); ++i)
      slots[study.parameters.size() + i] = metrics[i] * Jet4(plan.scale[i].si);
    const auto put = [&](std::vector<double>& rows, std::size_t row, const Jet4& value) {
      for (std::size_t k = 0; k < count; ++k)
        if (std::isfinite(value.a)) rows[row * axes.size() + first + k] = value.v[static_cast<Eigen::Index>(k)];
    };
    for (std::size_t c = 0; c < metrics.size(); ++c) put(gradient.value, c, metrics[c]);
    std::size_t column = metrics.size();
    for (std::size_t i = 0; i < study.objectives.size(); ++i) {
      const Objective& objective = study.objectives[i];
      const Jet4 value = objective.expression.evaluate<Jet4>(slots) / Jet4(objective.si);
      put(gradient.objective, i, value);
      if (!objective.expression.only_slot()) put(gradient.value, column++, value);
    }
    for (std::size_t i = 0; i < study.constraints.size(); ++i) {
      const Constraint& constraint = study.constraints[i];
      const Jet4 margin = constraint.right.evaluate<Jet4>(slots) - constraint.left.evaluate<Jet4>(slots);
      put(gradient.margin, i, constraint.less ? margin : -margin);
    }
  }
  return gradient;
}

}  // namespace study
