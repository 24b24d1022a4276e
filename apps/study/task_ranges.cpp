// SPDX-License-Identifier: Apache-2.0
#include "apps/study/task_ranges.h"

#include <algorithm>
#include <cmath>

#include "apps/study/design/design_model.h"
#include "apps/study/design/metric_rows.h"
#include "apps/study/study_reader.h"
#include "mtf/error.h"

namespace study {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Study study_of(const mtf::io::SensorConfig& sensor, const Conditions& conditions, double tolerance) {
  if (conditions.extinction_per_km)
    if (const std::string why = extinction_problem(sensor); !why.empty())
      throw mtf::UsageError("[conditions] extinction: " + why);
  Study study;
  study.base = sensor;
  study.conditions = conditions;
  study.tolerance = tolerance;
  for (const RangeTask& task : range_tasks(conditions)) study.metrics.push_back(*find_metric(row_of(task.metric).name));
  return study;
}

/// Probabilities of a task against range, and by how much they may be less.
struct Course {
  std::vector<double> probability, error;
};

/// The one design of a study without axes.
class OneSensor {
 public:
  OneSensor(const mtf::io::SensorConfig& sensor, const Conditions& conditions, double tolerance)
      : study_(study_of(sensor, conditions, tolerance)),
        variant_(load_variant(study_, {})),
        plan_(plan_metrics(study_, tolerance)) {
    if (!variant_.problems.empty()) throw mtf::UsageError(variant_.problems.front());
    for (std::size_t i = 0; i < kRangeTasks; ++i) {
      reason_[i] = metric_gap(plan_.choices[i], study_, variant_);
      plan_.range[i] = reason_[i].empty();
    }
    if (!std::any_of(plan_.range.begin(), plan_.range.end(), [](bool asked) { return asked; })) return;
    light_ = light_of(variant_, study_, {}, {.numbers = true, .otf = false, .ranges = true});
    model_ = std::make_unique<DesignModel<double>>(study_, plan_, variant_, variant_.system);
    model_->set_light(light_);
    std::vector<double> values(study_.metrics.size());
    model_->metrics(light_.numbers, light_, values);
    for (std::size_t i = 0; i < kRangeTasks; ++i) {
      range_m_[i] = values[i];
      if (!reason_[i].empty() || std::isfinite(values[i])) continue;
      const std::string& refused = model_->roots()[i].refusal;
      reason_[i] = refused.empty() ? model_->refusal() : refused;
    }
  }
  OneSensor(const OneSensor&) = delete;  // the model refers to the others
  OneSensor& operator=(const OneSensor&) = delete;

  const Study& study() const { return study_; }
  double range_m(std::size_t task) const { return range_m_[task]; }
  const std::string& reason(std::size_t task) const { return reason_[task]; }
  RangeRoot root(std::size_t task) const { return model_ ? model_->roots()[task] : RangeRoot{}; }
  std::string caution() const { return model_ ? model_->caution() : ""; }
  radiometry::Reach reach() const { return light_.course ? light_.course->reach() : radiometry::Reach{}; }

  /// Empty for a task whose model refuses the sensor.
  std::array<Course, kRangeTasks> courses(std::span<const double> range_m) {
    std::array<Course, kRangeTasks> courses;
    const std::array<RangeTask, kRangeTasks> tasks = range_tasks(study_.conditions);
    for (const bool by_bars : {true, false}) {
      std::vector<RangeSolver::Resolved> resolved;
      const auto asked = [&](std::size_t i) { return tasks[i].by_bars == by_bars && plan_.range[i]; };
      for (std::size_t i = 0; i < kRangeTasks && resolved.empty(); ++i)
        if (asked(i) && model_ && light_.course) resolved = model_->resolved(light_, by_bars, range_m);
      for (std::size_t i = 0; i < kRangeTasks; ++i)
        if (asked(i))
          for (const RangeSolver::Resolved& one : resolved) {
            const auto probability = [&](double cycles) {
              return std::isnan(cycles) ? kNone : radiometry::task_probability(tasks[i].law(), cycles / tasks[i].half);
            };
            courses[i].probability.push_back(probability(one.cycles));
            courses[i].error.push_back(courses[i].probability.back() - probability(one.least));
          }
    }
    return courses;
  }

 private:
  Study study_;
  VariantSensor variant_;
  MetricPlan plan_;
  DesignLight light_{};
  std::unique_ptr<DesignModel<double>> model_{};
  std::array<std::string, kRangeTasks> reason_{};
  std::array<double, kRangeTasks> range_m_{kNone, kNone, kNone, kNone, kNone, kNone};
};

/// Round lengths, ten a decade, from a third of the shortest range to a quarter more than the longest.
std::vector<double> round_lengths(const OneSensor& sensor) {
  const radiometry::Reach reach = sensor.reach();
  double nearest = mtf::kInfinity, farthest = 0.0;
  for (std::size_t i = 0; i < kRangeTasks; ++i) {
    const double range = sensor.range_m(i);
    if (range > 0.0) nearest = std::min(nearest, range / 3.0), farthest = std::max(farthest, 1.25 * range);
    if (!sensor.root(i).refusal.empty() && std::isfinite(reach.most_m))
      farthest = reach.most_m;  // it may succeed there
  }
  constexpr double kFarthest = 1e3;  // sizes of the target, where nothing is seen at any range
  if (!(farthest > 0.0)) farthest = kFarthest * *sensor.study().conditions.target_size_m;
  farthest = std::min(std::max(farthest, 10.0 * reach.least_m), reach.most_m);
  nearest = std::max(std::min(nearest, farthest / 10.0), reach.least_m);
  std::vector<double> range_m;
  for (double decade = std::pow(10.0, std::floor(std::log10(nearest))); decade <= farthest; decade *= 10.0)
    for (const double round : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
      if (const double range = round * decade; range >= nearest && range <= farthest) range_m.push_back(range);
  return range_m;
}

/// So many steps from each to the next.
std::vector<double> in_steps(const std::vector<double>& range_m, int steps) {
  std::vector<double> fine;
  for (std::size_t r = 0; r + 1 < range_m.size(); ++r)
    for (int k = 0; k < steps; ++k) fine.push_back(range_m[r] + (range_m[r + 1] - range_m[r]) * k / steps);
  if (!range_m.empty()) fine.push_back(range_m.back());
  return fine;
}

/// The file with one of its numbers moved, or why it cannot be.
std::unique_ptr<OneSensor> moved(const OneSensor& sensor, std::size_t fit, double value, double tolerance,
                                 std::string& problem) {
  const mtf::io::SensorConfig& file = sensor.study().base;
  std::vector<std::optional<double>> values(file.fits.size());
  values[fit] = value;
  const mtf::io::ConfigResult result =
      mtf::io::parse_config(mtf::io::splice_fits(file, values), file.file, file.schema);
  for (const mtf::io::Diagnostic& wrong : result.diagnostics)
    if (wrong.error) {
      problem = wrong.text;
      return nullptr;
    }
  try {
    return std::make_unique<OneSensor>(result.config, sensor.study().conditions, tolerance);
  } catch (const mtf::UsageError& refused) {
    problem = refused.what();
    return nullptr;
  }
}

/// Half of what a number makes that is moved to both sides; of one side alone, all of what that makes.
double half_of(double middle, const double* high, const double* low) {
  return high != nullptr && low != nullptr ? 0.5 * (*high - *low) : high != nullptr ? *high - middle : middle - *low;
}

void add_stated(const OneSensor& middle, double tolerance, Acquisition& found) {
  const std::vector<mtf::io::FitSpec>& fits = middle.study().base.fits;
  for (std::size_t f = 0; f < fits.size(); ++f) {
    const double sd = fits[f].sd();
    if (!(sd > 0.0)) continue;
    StatedNumber stated{.path = fits[f].path, .unit = fits[f].unit, .value = fits[f].value, .sd = sd};
    const auto high = moved(middle, f, fits[f].value + sd, tolerance, stated.problem),
               low = moved(middle, f, fits[f].value - sd, tolerance, stated.problem);
    if (high || low) stated.problem.clear();
    using Courses = std::optional<std::array<Course, kRangeTasks>>;
    const Courses up = high ? Courses(high->courses(found.range_m)) : Courses(),
                  down = low ? Courses(low->courses(found.range_m)) : Courses();
    for (std::size_t i = 0; i < kRangeTasks; ++i) {
      const auto half = [&](double here, const auto& of_side) {
        const double above = high ? of_side(*high, *up) : kNone, below = low ? of_side(*low, *down) : kNone;
        const bool has_above = !std::isnan(above), has_below = !std::isnan(below);
        return has_above || has_below ? half_of(here, has_above ? &above : nullptr, has_below ? &below : nullptr)
                                      : kNone;
      };
      TaskRange& task = found.tasks[i];
      stated.moves_m[i] = half(task.range_m, [&](const OneSensor& side, const auto&) { return side.range_m(i); });
      task.sd_m = std::hypot(task.sd_m, stated.moves_m[i]);
      if (std::isnan(stated.moves_m[i]) && std::isfinite(task.range_m) && stated.problem.empty())
        stated.problem = high ? high->reason(i) : low->reason(i);
      for (std::size_t r = 0; r < task.probability.size(); ++r) {
        const double by = half(task.probability[r], [&](const OneSensor&, const std::array<Course, kRangeTasks>& side) {
          return r < side[i].probability.size() ? side[i].probability[r] : kNone;
        });
        task.probability_sd[r] = std::hypot(task.probability_sd[r], by);
      }
    }
    found.stated.push_back(std::move(stated));
  }
}

}  // namespace

Acquisition acquisition(const mtf::io::SensorConfig& sensor, const Conditions& conditions,
                        std::span<const double> range_m, double tolerance, int steps) {
  OneSensor middle(sensor, conditions, tolerance);
  Acquisition found;
  for (std::size_t i = 0; i < kRangeTasks; ++i) {
    const RangeTask task = range_tasks(conditions)[i];
    const RangeRoot root = middle.root(i);
    TaskRange& out = found.tasks[i];
    constexpr std::array kTaskNames{"detect", "recognise", "identify"};
    out.metric = row_of(task.metric).name;
    out.task = kTaskNames[i % 3];
    out.model = task.by_bars ? "johnson" : "ttp";
    out.half = task.half;
    out.range_m = middle.range_m(i);
    out.error_m = root.error * out.range_m;
    out.at_nyquist = root.at_nyquist;
    out.fills_field = root.fills_field;
    out.reason = middle.reason(i);
  }
  found.filled_m = range_filling_the_field_m(sensor.system.frame, *conditions.target_size_m);
  const radiometry::Reach reach = middle.reach();
  if (range_m.empty())
    found.range_m = in_steps(round_lengths(middle), steps);
  else
    for (const double range : range_m)
      if (range >= reach.least_m && range <= reach.most_m) found.range_m.push_back(range);
  const auto metres = [](double m) { return mtf::format_double(std::round(m)) + " m"; };
  if (!range_m.empty() && range_m.back() > reach.most_m)
    found.cautions.push_back("no probabilities beyond " + metres(reach.most_m) + ", where " + reach.end);
  if (!range_m.empty() && range_m.front() < reach.least_m)
    found.cautions.push_back("no probabilities nearer than " + metres(reach.least_m) +
                             ", the difference of the altitudes");
  if (!found.range_m.empty() && found.range_m.front() < found.filled_m)
    found.cautions.push_back("nearer than " + metres(found.filled_m) +
                             " the target is wider than the field of view, of which the models know nothing");
  const std::array<Course, kRangeTasks> courses = middle.courses(found.range_m);
  for (std::size_t i = 0; i < kRangeTasks; ++i) {
    found.tasks[i].probability = courses[i].probability;
    found.tasks[i].probability_error = courses[i].error;
    found.tasks[i].probability_sd.assign(courses[i].probability.size(), 0.0);
  }
  const auto nothing = [](const TaskRange& task) {
    const auto known = [](double p) { return std::isfinite(p); };
    return !task.reason.empty() && std::none_of(task.probability.begin(), task.probability.end(), known);
  };
  if (std::all_of(found.tasks.begin(), found.tasks.end(), nothing)) throw mtf::UsageError(found.tasks.front().reason);
  add_stated(middle, tolerance, found);
  found.lines = condition_lines(middle.study());
  if (const std::string caution = middle.caution(); !caution.empty()) found.cautions.push_back(caution);
  return found;
}

}  // namespace study
