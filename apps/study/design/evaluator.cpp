// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/evaluator.h"

#include <cmath>
#include <map>

#include "apps/study/design/design_light.h"
#include "apps/study/design/design_model.h"
#include "apps/study/design/metric_rows.h"
#include "mtf/error.h"

namespace study {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// An objective that is nothing but a metric or a parameter has no column of its own.
bool has_column(const Study& study, const Objective& objective) {
  const std::optional<int> slot = objective.expression.only_slot();
  if (!slot) return true;
  const auto i = static_cast<std::size_t>(*slot);
  return i < study.parameters.size() && study.parameters[i].role == Parameter::Role::fixed;  // no column of its own
}

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

std::vector<Column> columns_of(const Study& study) {
  std::vector<Column> columns;
  for (const Axis& axis : study.axes) {
    const Parameter& parameter = study.parameters[static_cast<std::size_t>(axis.parameter)];
    columns.push_back({parameter.name, parameter.unit, "parameter that the study varies", "study file",
                       Column::Role::axis, axis.levels});
  }
  for (const Link& link : study.links) {
    const Parameter& parameter = study.parameters[static_cast<std::size_t>(link.parameter)];
    columns.push_back(
        {parameter.name, parameter.unit, "= " + link.expression.text(), "study file", Column::Role::link});
  }
  for (const MetricInfo& metric : study.metrics)
    columns.push_back({metric.name, metric.unit, metric.definition, metric.source, Column::Role::metric});
  for (const Objective& objective : study.objectives)
    if (has_column(study, objective))
      columns.push_back({objective.text, objective.unit, objective.maximize ? "to be maximized" : "to be minimized",
                         "study file", Column::Role::objective});
  if (!study.constraints.empty())
    columns.push_back({"feasible", "", "1 where every constraint holds", "study file", Column::Role::feasible});
  if (study.draws > 0)
    columns.push_back({"yield", "",
                       "share of as-built draws that meet every constraint; one that no sensor can be meets none",
                       "study file", Column::Role::yield});
  columns.push_back({"error", "",
                     "largest error of the metrics, estimated: absolute where they are at most 1, else relative",
                     "mtf/otf/otf_series.h", Column::Role::error});
  return columns;
}

struct Evaluator::Impl {
  std::shared_ptr<const Study> study;
  MetricPlan plan;
  struct Ready {
    VariantSensor sensor;
    std::unique_ptr<DesignModel<double>> model;
    KeptLight light;
    std::uint64_t used = 0;  ///< when last
  };
  std::map<std::vector<int>, std::unique_ptr<Ready>> variants{};
  std::vector<double> axis_values{}, parameters{}, metrics{}, slots{}, objectives{};
  std::vector<ConstraintValues> sides{};
  std::vector<int> levels{};
  std::uint64_t uses = 0;
  bool valid = false;
  const DesignModel<double>* worked_out = nullptr;  ///< that of the last design, where it is a sensor
  std::string problem{}, refusal{}, first_problem{}, first_refusal{};

  explicit Impl(std::shared_ptr<const Study> s) : study(std::move(s)), plan(plan_metrics(*study, study->tolerance)) {
    axis_values.resize(study->axes.size());
    levels.resize(study->axes.size());
    parameters.resize(study->parameters.size());
    metrics.resize(study->metrics.size());
    slots.resize(study->slots());
    objectives.resize(study->objectives.size());
    sides.resize(study->constraints.size());
  }

  /// The sensor for these values of the discrete axes. Only so many are kept: the one not used for longest goes.
  Ready& ready(std::span<const double> values) {
    for (std::size_t a = 0; a < study->axes.size(); ++a)
      levels[a] = study->axes[a].discrete() ? static_cast<int>(values[a]) : 0;
    const auto found = variants.find(levels);
    if (found != variants.end()) {
      found->second->used = ++uses;
      return *found->second;
    }
    constexpr std::size_t kMost = 64;
    if (variants.size() >= kMost)
      variants.erase(std::min_element(variants.begin(), variants.end(),
                                      [](const auto& a, const auto& b) { return a.second->used < b.second->used; }));
    auto fresh = std::make_unique<Ready>();
    fresh->used = ++uses;
    fresh->sensor = load_variant(*study, levels);
    if (fresh->sensor.problems.empty())
      fresh->model = std::make_unique<DesignModel<double>>(*study, plan, fresh->sensor, fresh->sensor.system);
    return *variants.emplace(levels, std::move(fresh)).first->second;
  }

  /// A value out of the range of its field; "" when it is inside.
  static std::string out_of_range(const Parameter& p, double value) {
    if (!std::isfinite(value)) return p.name + " = " + mtf::format_double(value) + " is no finite number";
    const bool above = p.lo_open ? value > p.lo : value >= p.lo, below = p.hi_open ? value < p.hi : value <= p.hi;
    if (above && below) return {};
    return p.name + " = " + mtf::format_double(value) + (p.unit.empty() ? "" : " " + p.unit) + " is outside " +
           (p.lo_open ? "(" : "[") + mtf::format_double(p.lo) + ", " + mtf::format_double(p.hi) +
           (p.hi_open ? ")" : "]");
  }

  /// Axes, then links, then as-built variation. False when a value is out of range.
  bool fill_parameters(const Ready& variant, std::span<const double> values, std::span<const double> shift) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Parameter& p = study->parameters[i];
      parameters[i] = p.path.empty() ? p.base : variant.sensor.base[i];
      slots[i] = parameters[i] * p.scale.si;
    }
    const auto put = [&](int parameter, double value) {
      const auto i = static_cast<std::size_t>(parameter);
      parameters[i] = value;
      slots[i] = value * study->parameters[i].scale.si;
      if (problem.empty()) problem = out_of_range(study->parameters[i], value);
    };
    for (std::size_t a = 0; a < study->axes.size(); ++a) {
      const Axis& axis = study->axes[a];
      if (!axis.discrete()) {
        put(axis.parameter, values[a]);
        continue;
      }
      const auto i = static_cast<std::size_t>(axis.parameter);
      parameters[i] = axis.values[static_cast<std::size_t>(values[a])];
      slots[i] = parameters[i] * study->parameters[i].scale.si;
    }
    for (const Link& link : study->links)
      put(link.parameter, link.expression.evaluate<double>(slots) /
                              study->parameters[static_cast<std::size_t>(link.parameter)].scale.si);
    for (std::size_t k = 0; k < shift.size(); ++k) {
      const int parameter = study->as_built[k].parameter;
      put(parameter, parameters[static_cast<std::size_t>(parameter)] + shift[k]);
    }
    return problem.empty();
  }
  /// The sensor with these numbers; its light, null when no sensor has them.
  const DesignLight* set_system(Ready& variant) {
    variant.model->set(parameters);
    for (const AsBuilt& built : study->as_built) {
      const auto i = static_cast<std::size_t>(built.parameter);
      if (study->parameters[i].role == Parameter::Role::fixed) variant.model->set_fixed(i, parameters[i]);
    }
    if (variant.sensor.loaded)
      problem = radiometry::frame_time_problem(variant.model->system(), variant.sensor.loaded->sensor.settings);
    if (!problem.empty()) return nullptr;
    const DesignLight* light = nullptr;
    try {
      light = &variant.light.at(variant.sensor, *study, variant.model->overrides(),
                                {.numbers = plan.budget, .otf = plan.resolution, .ranges = plan.air});
    } catch (const mtf::UsageError& refused) {
      problem = refused.what();
      return nullptr;
    }
    variant.model->set_light(*light);
    const auto errors = variant.model->system().errors();
    if (errors.empty()) return light;
    const auto& [where, what] = errors.front();
    problem = where + (what.field.empty() ? "" : "." + what.field) + ": " + what.text;
    return nullptr;
  }
  void write_row(std::span<double> row) {
    std::size_t c = 0;
    for (const Axis& axis : study->axes) row[c++] = parameters[static_cast<std::size_t>(axis.parameter)];
    for (const Link& link : study->links) row[c++] = parameters[static_cast<std::size_t>(link.parameter)];
    for (const double metric : metrics) row[c++] = metric;
    const bool possible = problem.empty();
    for (std::size_t i = 0; i < objectives.size(); ++i) {
      const Objective& objective = study->objectives[i];
      objectives[i] = possible ? objective.expression.evaluate<double>(slots) / objective.si : kNan;
      if (has_column(*study, objective)) row[c++] = std::isfinite(objectives[i]) ? objectives[i] : kNan;
    }
    const auto finite = [](double value) { return std::isfinite(value); };
    valid = possible && std::all_of(objectives.begin(), objectives.end(), finite);
    bool feasible = valid;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const Constraint& constraint = study->constraints[i];
      sides[i] =
          possible ? ConstraintValues{constraint.left.evaluate<double>(slots), constraint.right.evaluate<double>(slots)}
                   : ConstraintValues{kNan, kNan};
      const double margin = sides[i].margin(constraint.less);
      feasible = feasible && sides[i].finite() && (constraint.strict ? margin > 0.0 : margin >= 0.0);
    }
    valid = valid && std::all_of(sides.begin(), sides.end(), [](const ConstraintValues& s) { return s.finite(); });
    if (!sides.empty()) row[c] = feasible ? 1.0 : 0.0;
  }
  void evaluate_at(std::span<const double> values, std::span<double> row, std::span<const double> shift) {
    problem.clear();
    refusal.clear();
    worked_out = nullptr;
    Ready& variant = ready(values);
    std::fill(metrics.begin(), metrics.end(), kNan);
    std::fill(parameters.begin(), parameters.end(), kNan);
    std::fill(row.begin(), row.end(), kNan);
    double error = kNan;
    if (!variant.sensor.problems.empty()) {
      problem = variant.sensor.problems.front();
      for (std::size_t a = 0; a < study->axes.size(); ++a) {
        const Axis& axis = study->axes[a];
        parameters[static_cast<std::size_t>(axis.parameter)] =
            axis.discrete() ? axis.values[static_cast<std::size_t>(values[a])] : values[a];
      }
    } else if (const DesignLight* light = fill_parameters(variant, values, shift) ? set_system(variant) : nullptr) {
      try {
        variant.model->metrics(light->numbers, *light, metrics);
        error = variant.model->error();
        // Air that is not there to be changed, because the chain is refused or each pixel has its own range.
        const bool no_air = !variant.sensor.loaded || !variant.sensor.loaded->sensor.air;
        const radiometry::Overrides<double> overrides(variant.model->overrides());
        if (no_air && plan.resolution && overrides.any(radiometry::changes_color)) error = kNan;
        refusal = variant.model->refusal();
        worked_out = variant.model.get();
        if (first_refusal.empty()) first_refusal = refusal;
      } catch (const mtf::UsageError& refused) {
        problem = refused.what();
        std::fill(metrics.begin(), metrics.end(), kNan);
      }
    }
    if (!problem.empty() && first_problem.empty()) first_problem = problem;
    for (std::size_t i = 0; i < metrics.size(); ++i)
      slots[study->parameters.size() + i] = metrics[i] * plan.scale[i].si;
    write_row(row);
    row.back() = error;
  }
};

Evaluator::Evaluator(std::shared_ptr<const Study> study) : impl_(std::make_unique<Impl>(std::move(study))) {}
Evaluator::~Evaluator() = default;
Evaluator::Evaluator(Evaluator&&) noexcept = default;

void Evaluator::evaluate(std::int64_t design, std::span<double> row) {
  design_at(*impl_->study, design, impl_->axis_values);
  impl_->evaluate_at(impl_->axis_values, row, {});
}

void Evaluator::evaluate_at(std::span<const double> axis_values, std::span<double> row, std::span<const double> shift) {
  impl_->evaluate_at(axis_values, row, shift);
}

const std::string& Evaluator::last_problem() const { return impl_->problem; }
bool Evaluator::last_valid() const { return impl_->valid; }
const std::string& Evaluator::last_refusal() const { return impl_->refusal; }
std::string Evaluator::last_caution() const {
  if (impl_->worked_out == nullptr) return "";
  std::string text = impl_->worked_out->caution();
  if (const std::string ranges = impl_->worked_out->caution_of_ranges(); !ranges.empty())
    text += (text.empty() ? "" : "; ") + ranges;
  for (const auto& [where, problem] : impl_->worked_out->system().check())
    text +=
        (text.empty() ? "" : "; ") + where + (problem.field.empty() ? "" : "." + problem.field) + ": " + problem.text;
  return text;
}
std::span<const double> Evaluator::last_objectives() const { return impl_->objectives; }
std::span<const ConstraintValues> Evaluator::last_sides() const { return impl_->sides; }

Gradient Evaluator::gradient_at(std::span<const double> axis_values, double tolerance) {
  Impl& impl = *impl_;
  Impl::Ready& variant = impl.ready(axis_values);
  impl.problem.clear();
  const bool possible = variant.sensor.problems.empty() && impl.fill_parameters(variant, axis_values, {});
  const DesignLight* light = possible ? impl.set_system(variant) : nullptr;
  return gradient_of(*impl.study, variant.sensor, light, impl.parameters, tolerance);
}

std::vector<std::string> Evaluator::gaps() const {
  // For the base variant: whatever a metric needs that neither the sensor nor the study has.
  const Study& study = *impl_->study;
  std::vector<std::string> gaps;
  const std::vector<double> levels(study.axes.size(), 0.0);
  const VariantSensor& sensor = impl_->ready(levels).sensor;
  for (const Column& column : columns_of(study)) {
    const auto choice = column.role == Column::Role::metric ? choose_metric(column.name) : std::nullopt;
    gaps.push_back(choice ? metric_gap(*choice, study, sensor) : "");
  }
  return gaps;
}

std::vector<std::string> Evaluator::skipped() const {
  const MetricPlan& plan = impl_->plan;
  const mtf::AxisNeeds& axis = plan.needs.axis;
  std::vector<std::string> sentences;
  if (!impl_->first_problem.empty())
    sentences.push_back("designs that are impossible as a sensor have no numbers; the first: " + impl_->first_problem);
  if (!impl_->first_refusal.empty())
    sentences.push_back("metrics without a number; the first: " + impl_->first_refusal);
  const mtf::System<double>& base = impl_->study->base.system;
  if (plan.resolution && !base.is_isoplanatic() && plan.over_field.size() < plan.choices.size())
    sentences.push_back("the OTF changes over the field by " + mtf::names_over_field(base) +
                        ": metrics without .mean or .worst are those of the optical axis");
  if (std::ranges::any_of(impl_->variants,
                          [](const auto& v) { return v.second->model && !v.second->model->follows_tables(); }))
    sentences.emplace_back(
        "tables over the field have positions that are closer than the places of .mean and .worst, whose error is not "
        "known: mtf curve --map looks at more");
  const auto skip = [&](bool needed, const char* what) {
    if (!needed) sentences.emplace_back(std::string(what) + ": no metric needs it");
  };
  skip(plan.resolution, "the OTF");
  if (plan.resolution) {
    skip(plan.needs.y, "the OTF along y");
    skip(axis.edge || axis.overshoot || axis.fwhm, "edge and line spread");
    skip(axis.aliasing || axis.spurious, "aliasing");
    skip(plan.needs.strehl || plan.needs.ensquared, "integrals over the pupil's OTF");
  }
  skip(plan.budget, "signal and noise");
  skip(plan.bars || plan.air, "MRTD and range models");
  const auto& parameters = impl_->study->parameters;
  if (plan.budget && std::none_of(parameters.begin(), parameters.end(),
                                  [](const Parameter& p) { return radiometry::is_spectral(p.path); }))
    sentences.emplace_back(
        "band integrals of the scene's radiance: computed once for each variant, shared by all its designs");
  if (impl_->study->variants > 0)
    sentences.emplace_back("sensor files, curves and wavelength nodes: read once for " +
                           std::to_string(impl_->study->variants) +
                           (impl_->study->variants == 1 ? " variant" : " variants"));
  return sentences;
}

mtf::io::SensorConfig Evaluator::sensor_at(std::span<const double> axis_values) {
  Impl& impl = *impl_;
  Impl::Ready& variant = impl.ready(axis_values);
  impl.problem.clear();
  if (!variant.sensor.problems.empty()) throw mtf::UsageError(variant.sensor.problems.front());
  if (!impl.fill_parameters(variant, axis_values, {}) || !impl.set_system(variant)) throw mtf::UsageError(impl.problem);
  mtf::io::SensorConfig config = variant.sensor.config;
  config.system = variant.model->system();
  for (auto& list : config.system.stages)  // components of its own: those of the model are overwritten
    for (auto& entry : list) entry.component.fields();
  config.system.band = variant.sensor.config.system.band;  // without the electron rate, which no file has
  for (const auto& override_ : variant.model->overrides()) {
    const std::size_t dot = override_.path.find('.');
    for (mtf::SettingsTable& table : config.tables)
      if (table.name == override_.path.substr(0, dot))
        for (mtf::GivenSetting& setting : table.settings)
          if (setting.name == override_.path.substr(dot + 1)) setting.value = override_.value;
  }
  return config;
}

}  // namespace study
