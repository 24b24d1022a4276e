// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/design_ranges.h"

#include <algorithm>
#include <cmath>

namespace study {
namespace {

using radiometry::Reached;

double modulus(const mtf::Resolution<double>& curves, mtf::Axis axis, double f_cy_mm) {
  return (axis == mtf::Axis::x ? curves.curve_x : curves.curve_y).modulus(f_cy_mm);
}

}  // namespace

RangeRoots RangeSolver::solve(RangeModel<double>& model, const std::shared_ptr<LightCourse>& course,
                              const std::array<bool, kRangeTasks>& asked, bool same_otf, double tolerance) {
  if (course != course_) points_.clear();
  course_ = course;
  if (!same_otf)
    for (auto& [place, point] : points_) point.curves = nullptr;
  const auto level = [](double of) { return static_cast<int>(std::ceil(-2.0 * std::log10(of))); };
  constexpr int kLoose = 9, kTightest = 20;
  constexpr double kShare = 0.5;  // of what is allowed
  half_decades_ = std::min(level(kShare * tolerance), kLoose);
  RangeRoots roots = roots_of(model, asked);
  double worst = 0.0;
  for (const RangeRoot& root : roots) worst = std::max(worst, root.error);
  if (worst > tolerance) {  // infinite where the OTF at the root is below what it may err by
    half_decades_ = std::isfinite(worst)
                        ? std::clamp(half_decades_ + level(kShare * tolerance / worst), half_decades_, kTightest)
                        : kTightest;
    roots = roots_of(model, asked);
  }
  return roots;
}

RangeRoots RangeSolver::roots_of(RangeModel<double>& model, const std::array<bool, kRangeTasks>& asked) {
  constexpr double kGuess = 1e3;  // times the size of the target; then what the task before gave
  double bars_m = kGuess * model.conditions().target_size_m.value_or(1.0), ttp_m = bars_m;
  RangeRoots roots;
  const std::array<RangeTask, kRangeTasks> tasks = range_tasks(model.conditions());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (!asked[i]) continue;
    double& guess_m = tasks[i].by_bars ? bars_m : ttp_m;
    try {
      roots[i] = root_of(tasks[i], model, guess_m);
      if (roots[i].found.range_m > 0.0) guess_m = roots[i].found.range_m;
    } catch (const mtf::UsageError& refused) {
      roots[i].found.range_m = std::numeric_limits<double>::quiet_NaN();
      roots[i].refusal = refused.what();
    }
  }
  return roots;
}

RangeRoot RangeSolver::root_of(const RangeTask& task, RangeModel<double>& model, double guess_m) {
  constexpr double kNearest = 1e-6;  // of the target's size
  const radiometry::Reach& reach = course_->reach();
  const double size = *model.conditions().target_size_m;
  const double nyquist_m = task.by_bars ? model.nyquist_range_m(task) : mtf::kInfinity;
  const double least = std::max(reach.least_m, kNearest * size), most = std::min(reach.most_m, nyquist_m);
  RangeRoot root;
  if (!(least < most)) return root;
  root.found = radiometry::longest_range([&](double r) { return model.margin(task, frozen(model, r), r); }, least, most,
                                         guess_m);
  const auto margin = [&](double r) { return model.margin(task, followed(model, r), r); };
  if (course_->moves_otf())
    root.found = radiometry::longest_range(margin, least, most,
                                           root.found.reached == Reached::never ? least : root.found.range_m);
  if (root.found.reached == Reached::never) return root;
  root.fills_field = root.found.range_m < model.filled_m();
  root.at_nyquist = root.found.reached == Reached::beyond && most == nyquist_m;
  if (root.at_nyquist) return root;
  if (root.found.reached == Reached::beyond)
    throw mtf::UsageError("the task still succeeds at " + mtf::format_double(std::round(most)) + " m, where " +
                          reach.end);
  // Of the ratio itself, 1 at the root: a little farther the target may offer nothing, whose logarithm has no slope.
  constexpr double kStep = 1e-4;
  const double range = root.found.range_m,
               step = std::min({kStep, 0.49 * std::log(most / range), 0.49 * std::log(range / least)});
  root.slope = radiometry::slope_at([&](double l) { return std::expm1(margin(std::exp(l))); }, std::log(range), step);
  root.error = std::abs(model.margin(task, worst(model, followed(model, range), range), range) / root.slope);
  return root;
}

RangeSolver::Sensor RangeSolver::frozen(RangeModel<double>& model, double range_m) {
  return model.behind(course_->between(range_m), range_m, point_at(model, nullptr, 0).seen);
}

/// An OTF is nearly linear in the electrons of each wavelength, as those between the points of a panel are; what is
/// left is in error_between().
RangeSolver::Sensor RangeSolver::followed(RangeModel<double>& model, double range_m) {
  if (!course_->moves_otf()) return frozen(model, range_m);
  const RangePanel& panel = course_->panel(range_m, true);
  const std::vector<Curves> curves = curves_of(model, panel);
  const std::vector<double> weight = panel.weights(range_m);
  const LightAtRange light = course_->between(range_m);
  if (const Curves one = between(curves, weight)) return model.behind(light, range_m, model.seen(one));
  radiometry::SeenOtf<double> otf;
  otf.mtf = [&model, curves, weight](mtf::Axis axis, double f_cy_mrad) {
    double sum = 0.0;
    for (std::size_t k = 0; k < weight.size(); ++k)
      sum += weight[k] * modulus(*curves[k], axis, model.cy_mm(f_cy_mrad));
    return std::max(sum, 0.0);
  };
  for (const Curves& one : curves) {
    const radiometry::SeenOtf<double> seen = model.seen(one);
    for (std::size_t axis = 0; axis < 2; ++axis)
      otf.reversal_cy_mrad[axis] = std::min(otf.reversal_cy_mrad[axis], seen.reversal_cy_mrad[axis]);
  }
  return model.behind(light, range_m, std::move(otf));
}

RangeSolver::Curves RangeSolver::between(const std::vector<Curves>& curves, const std::vector<double>& weight) {
  const auto sum = std::make_shared<mtf::Resolution<double>>();
  for (std::size_t k = 0; k < curves.size(); ++k)
    if (!sum->curve_x.add(curves[k]->curve_x, weight[k]) || !sum->curve_y.add(curves[k]->curve_y, weight[k]))
      return nullptr;
  return sum;
}

/// `panel`: null for the OTF without air.
const RangeSolver::Point& RangeSolver::point_at(RangeModel<double>& model, const RangePanel* panel, std::size_t k) {
  const std::tuple place(half_decades_, panel, k);
  auto found = points_.find(place);
  if (found == points_.end())
    found = points_
                .emplace(place, Point{mtf::ResolutionMeter<double>(curves_alone(std::pow(10.0, -0.5 * half_decades_))),
                                      nullptr,
                                      {}})
                .first;
  Point& point = found->second;
  if (!point.curves) {
    point.curves = std::make_shared<const mtf::Resolution<double>>(
        model.measured(panel != nullptr ? panel->colour[k] : course_->colour_at(0.0), point.meter));
    point.seen = model.seen(point.curves);
  }
  return point;
}

std::vector<RangeSolver::Curves> RangeSolver::curves_of(RangeModel<double>& model, const RangePanel& panel) {
  std::vector<Curves> curves;
  for (std::size_t k = 0; k < panel.colour.size(); ++k) curves.push_back(point_at(model, &panel, k).curves);
  return curves;
}

RangeSolver::Resolved RangeSolver::resolved(RangeModel<double>& model, bool by_bars, double range_m) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (course_ == nullptr) return {kNone, kNone};  // no range was looked for
  try {
    const Sensor seen = followed(model, range_m);
    return {model.cycles(by_bars, seen, range_m), model.cycles(by_bars, worst(model, seen, range_m), range_m)};
  } catch (const mtf::UsageError&) {
    return {kNone, kNone};
  }
}

/// Less contrast, more noise and a lower MTF, each by what it may be wrong.
RangeSolver::Sensor RangeSolver::worst(RangeModel<double>& model, Sensor sensor, double range) {
  const double light = course_->error(range);
  double otf = point_at(model, nullptr, 0).curves->error;
  if (course_->moves_otf()) {
    const RangePanel& panel = course_->panel(range, true);
    const std::vector<Curves> curves = curves_of(model, panel);
    for (const Curves& one : curves) otf = std::max(otf, one->error);
    otf += error_between(curves, model.cy_mm(model.counted_cy_mrad()));
  }
  sensor.contrast_share *= std::max(0.0, 1.0 - light);
  sensor.netd_k *= 1.0 + light;
  sensor.spatial_netd_k *= 1.0 + light;
  sensor.otf.mtf = [mtf = sensor.otf.mtf, otf](mtf::Axis axis, double f) { return std::max(0.0, mtf(axis, f) - otf); };
  return sensor;
}

/// Of the OTF between the points of a panel: what the series over the range leaves at frequencies of all the band.
double RangeSolver::error_between(const std::vector<Curves>& curves, double end_cy_mm) {
  constexpr int kFrequencies = 8;
  double worst = 0.0;
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y})
    for (int i = 1; i <= kFrequencies; ++i) {
      std::vector<double> values;
      for (const Curves& one : curves) values.push_back(modulus(*one, axis, end_cy_mm * i / (kFrequencies + 1)));
      worst = std::max(worst, panel_error(std::move(values)));
    }
  return worst;
}

}  // namespace study
