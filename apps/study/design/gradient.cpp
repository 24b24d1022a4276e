// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <exception>

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

/// A difference formula of fourth order: the derivative is the sum of weight x (value at the step - value in the
/// middle), over 12 h. Without the middle, values that do not change at all would leave their rounding.
struct Stencil {
  std::array<double, 5> step, weight;
};
constexpr std::array<Stencil, 3> kStencils{{{{-2.0, -1.0, 0.0, 1.0, 2.0}, {1.0, -8.0, 0.0, 8.0, -1.0}},
                                            {{0.0, 1.0, 2.0, 3.0, 4.0}, {-25.0, 48.0, -36.0, 16.0, -3.0}},
                                            {{-4.0, -3.0, -2.0, -1.0, 0.0}, {3.0, -16.0, 36.0, -48.0, 25.0}}}};

/// The light of a design at the five places of a stencil, where one of its numbers differs.
struct LightAround {
  std::size_t number = 0;  ///< index of the override
  bool moves_otf = false;
  Stencil stencil{};
  double h = 0.0;
  std::array<DesignLight, 5> light{};
};

class LightSlopes {
 public:
  LightSlopes(const Study& study, const MetricPlan& plan, const VariantSensor& variant, const DesignLight& here,
              std::span<const radiometry::Override<Jet4>> overrides)
      : study_(study),
        variant_(variant),
        needs_{.numbers = plan.budget, .otf = plan.resolution, .ranges = plan.air},
        here_(here) {
    for (const auto& o : overrides) plain_.push_back({o.path, o.value.a});
    for (std::size_t i = 0; i < plain_.size(); ++i)
      if (radiometry::is_spectral(plain_[i].path) && !overrides[i].value.v.isZero()) around_.push_back(around(i));
  }

  const DesignLight& here() const { return here_; }
  const std::vector<LightAround>& around() const { return around_; }

  /// Band integrals as jets: their values, and slopes by those of their numbers that carry derivatives.
  radiometry::SpectralNumbers<Jet4> numbers(std::span<const radiometry::Override<Jet4>> overrides) {
    radiometry::SpectralNumbers<Jet4> jets;
    const auto all = jets.all();
    const auto values = here_.numbers.all();
    for (std::size_t n = 0; n < all.size(); ++n) {
      *all[n] = Jet4(*values[n]);
      for (LightAround& one : around_) {
        double slope = 0.0;
        for (std::size_t k = 0; k < one.light.size(); ++k)
          if (one.stencil.weight[k] != 0.0)
            slope += one.stencil.weight[k] * (*one.light[k].numbers.all()[n] - *values[n]);
        all[n]->v += slope / (12.0 * one.h) * overrides[one.number].value.v;
      }
    }
    return jets;
  }

 private:
  DesignLight at() const { return light_of(variant_, study_, plain_, needs_); }

  /// Central where the number's range and the model of the air allow it, else one-sided. The slope of a band model at
  /// range 0 is infinite; the one at 1 m stands for it.
  LightAround around(std::size_t number) {
    radiometry::Override<double>& moved = plain_[number];
    const double value = moved.value;
    const auto parameter = std::find_if(study_.parameters.begin(), study_.parameters.end(),
                                        [&](const Parameter& p) { return p.path == moved.path; });
    const double least = moved.path == "atmosphere.range" ? 1.0 : 0.0;
    const double middle = std::max(value, least);
    LightAround result{
        .number = number,
        .moves_otf = (needs_.otf && radiometry::changes_color(moved.path)) || needs_.ranges,
        .h = 1e-3 * std::max({std::abs(value), moved.path.ends_with("_altitude") ? 100.0 : 1e-3, least})};
    std::exception_ptr refusal;
    for (const Stencil& stencil : kStencils) {
      result.stencil = stencil;
      if (middle + stencil.step.front() * result.h < std::max(parameter->lo, least) ||
          middle + stencil.step.back() * result.h > parameter->hi)
        continue;
      try {
        for (std::size_t k = 0; k < stencil.step.size(); ++k) {
          if (stencil.weight[k] == 0.0) continue;
          moved.value = middle + stencil.step[k] * result.h;
          result.light[k] = at();
        }
        moved.value = value;
        return result;
      } catch (const mtf::UsageError&) {
        refusal = std::current_exception();
        moved.value = value;
      }
    }
    if (refusal) std::rethrow_exception(refusal);
    throw mtf::UsageError(std::string(moved.path) + ": its range is too narrow for a derivative");
  }

  const Study& study_;
  const VariantSensor& variant_;
  LightNeeds needs_;
  DesignLight here_;
  std::vector<radiometry::Override<double>> plain_{};
  std::vector<LightAround> around_;
};

/// Adds to the slopes of the metrics what comes from the OTF's part of the light (DesignModel::set_light), which is no
/// jet, and from all of the light of ranges: the same differences, of the metrics with that part alone moved.
void add_slopes_of_otf(const LightSlopes& slopes, std::span<const radiometry::Override<Jet4>> overrides,
                       std::span<const double> parameters, DesignModel<double>& model, const RangeRoots& roots,
                       std::span<Jet4> metrics) {
  std::vector<double> moved(metrics.size()), middle(metrics.size());
  const auto metrics_in = [&](const DesignLight& light, std::vector<double>& values) {
    model.set(parameters);
    model.set_light(light);
    model.metrics(slopes.here().numbers, light, values, &roots);
  };
  if (std::any_of(slopes.around().begin(), slopes.around().end(), [](const auto& one) { return one.moves_otf; }))
    metrics_in(slopes.here(), middle);
  for (const LightAround& one : slopes.around()) {
    if (!one.moves_otf) continue;
    std::vector<double> slope(metrics.size(), 0.0);
    for (std::size_t k = 0; k < one.light.size(); ++k) {
      if (one.stencil.weight[k] == 0.0) continue;
      metrics_in(one.light[k], moved);
      for (std::size_t m = 0; m < moved.size(); ++m) slope[m] += one.stencil.weight[k] * (moved[m] - middle[m]);
    }
    for (std::size_t m = 0; m < moved.size(); ++m)
      metrics[m].v += slope[m] / (12.0 * one.h) * overrides[one.number].value.v;
  }
}

}  // namespace

Gradient gradient_of(const Study& study, const VariantSensor& variant, const DesignLight* light,
                     std::span<const double> parameters, double tolerance) {
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
  if (light == nullptr) return gradient;

  const MetricPlan plan = plan_metrics(study, std::min(study.tolerance, tolerance));
  DesignModel<Jet4> model(study, plan, variant, mtf::cast<Jet4>(variant.system));
  DesignModel<double> plain_model(study, plan, variant, variant.system);
  if (plan.air || plan.at_a_place) try {
      std::vector<double> values(study.metrics.size());
      plain_model.set(parameters);
      plain_model.set_light(*light);
      plain_model.metrics(light->numbers, *light, values);
    } catch (const mtf::UsageError&) {
      return gradient;  // as the row of this design: no metrics
    }
  model.follow(plain_model);
  const RangeRoots roots = plain_model.roots();
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
      LightSlopes slopes(study, plan, variant, *light, model.overrides());
      model.set_light(slopes.here());
      model.metrics(slopes.numbers(model.overrides()), *light, metrics, &roots);
      add_slopes_of_otf(slopes, model.overrides(), parameters, plain_model, roots, metrics);
    } catch (const mtf::UsageError&) {
      return gradient;
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
