// SPDX-License-Identifier: Apache-2.0

// From the metrics of a study to what has to be computed for them.

#include "apps/study/design/design_model.h"

namespace study {

namespace {

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
    switch (effort) {
      case Effort::geometry:
      case Effort::points:
      case Effort::budget:
        break;
      case Effort::grd:
        plan.needs.curves = plan.needs.y = true;
        break;
      case Effort::edge:
        axis.edge = true;
        break;
      case Effort::overshoot:
        axis.overshoot = true;
        break;
      case Effort::fwhm:
        axis.fwhm = true;
        break;
      case Effort::mtf50:
        axis.mtf50 = true;
        break;
      case Effort::area:
        axis.area = true;
        break;
      case Effort::aliasing:
        axis.aliasing = true;
        break;
      case Effort::spurious:
        axis.aliasing = axis.spurious = true;
        break;
      case Effort::light:
        (choice.row->metric == Metric::strehl ? plan.needs.strehl : plan.needs.ensquared) = true;
        break;
      case Effort::giqe:
        if (choice.row->metric == Metric::niirs_giqe5)
          axis.unfiltered = true;
        else
          axis.edge = axis.overshoot = plan.giqe = true;
        break;
      case Effort::bars:
        plan.bars = plan.needs.curves = plan.needs.y = true;
        break;
      case Effort::air:
        plan.air = true;
        plan.ttp = plan.ttp || metric == Metric::ttp;
        break;
    }
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
