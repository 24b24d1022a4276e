// SPDX-License-Identifier: Apache-2.0

// From the metrics of a study to what has to be computed for them.

#include "apps/study/design/design_model.h"

namespace study {
namespace {

/// What of each axis a metric needs, where it is one thing.
using Need = bool mtf::AxisNeeds::*;
constexpr std::array<std::pair<Effort, Need>, 7> kAxisNeeds{{{Effort::edge, &mtf::AxisNeeds::edge},
                                                             {Effort::overshoot, &mtf::AxisNeeds::overshoot},
                                                             {Effort::fwhm, &mtf::AxisNeeds::fwhm},
                                                             {Effort::mtf50, &mtf::AxisNeeds::mtf50},
                                                             {Effort::area, &mtf::AxisNeeds::area},
                                                             {Effort::aliasing, &mtf::AxisNeeds::aliasing},
                                                             {Effort::spurious, &mtf::AxisNeeds::spurious}}};

MetricPlan plan_of(const Study& study, std::span<const MetricInfo> metrics, double tolerance) {
  MetricPlan plan;
  plan.needs.tolerance = tolerance;
  plan.needs.y = false;
  for (const MetricInfo& info : metrics) {
    const MetricChoice choice = *choose_metric(info.name);
    if (choice.over != Over::axis) plan.over_field.push_back(plan.choices.size());
    plan.choices.push_back(choice);
    plan.scale.push_back(unit_scale(info.unit));
    plan.at.push_back(plan.needs.at.size());
    if (choice.row->metric == Metric::mtf_at) plan.needs.at.push_back(choice.at);
    mtf::AxisNeeds& axis = plan.needs.axis;
    const Effort effort = choice.row->effort;
    plan.resolution =
        plan.resolution || (effort != Effort::geometry && effort != Effort::budget && effort != Effort::air);
    plan.needs.y = plan.needs.y || effort == Effort::giqe || (choice.row->directional && choice.axis != mtf::Axis::x);
    const bool observed = effort == Effort::bars || effort == Effort::air;
    plan.budget =
        plan.budget || effort == Effort::budget || effort == Effort::giqe || effort == Effort::grd || observed;
    const Metric metric = choice.row->metric;
    plan.spatial = plan.spatial || observed || metric == Metric::prnu_noise || metric == Metric::dsnu_noise ||
                   metric == Metric::correction_noise || metric == Metric::spatial_noise ||
                   metric == Metric::spatial_netd;
    for (const auto& [of, need] : kAxisNeeds) axis.*need = axis.*need || effort == of;
    if (effort == Effort::spurious) axis.aliasing = true;
    if (effort == Effort::light) (metric == Metric::strehl ? plan.needs.strehl : plan.needs.ensquared) = true;
    if (effort == Effort::giqe && metric == Metric::niirs_giqe5)
      axis.unfiltered = true;
    else if (effort == Effort::giqe)
      axis.edge = axis.overshoot = plan.giqe = true;
    if (effort == Effort::grd || effort == Effort::bars) plan.needs.curves = plan.needs.y = true;
    plan.bars = plan.bars || effort == Effort::bars;
    plan.air = plan.air || effort == Effort::air;
    plan.ttp = plan.ttp || metric == Metric::ttp;
    const std::array<RangeTask, kRangeTasks> tasks = range_tasks(study.conditions);
    for (std::size_t i = 0; i < tasks.size(); ++i) plan.range[i] = plan.range[i] || tasks[i].metric == metric;
  }
  return plan;
}

}  // namespace

MetricPlan plan_metrics(const Study& study, double tolerance) {
  MetricPlan plan = plan_of(study, study.metrics, tolerance);
  std::vector<MetricInfo> over_field;
  for (const std::size_t i : plan.over_field) over_field.push_back(study.metrics[i]);
  // There are many places: slopes of a place are no finer than the study, or a millionth.
  constexpr double kOfAPlace = 1e-6;
  if (!over_field.empty())
    plan.at_a_place = std::make_shared<const MetricPlan>(
        plan_of(study, over_field, std::max(tolerance, std::min(study.tolerance, kOfAPlace))));
  return plan;
}

}  // namespace study
