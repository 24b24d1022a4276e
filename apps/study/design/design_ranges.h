// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ranges of a design, by Johnson's criteria and by TTP (radiometry/performance/target_at_range.h), with the air
// that lies on the way to the target. A range is the root of a margin:
//   with double   noise and contrast from the panels of the light (design_light.h), first with the OTF that the design
//                 has without air, then with that of each range, whose logarithm goes through the points of the panel.
//                 Its error: by how much the root moves when everything that was interpolated, and the OTF, is worse by
//                 what it may err.
//   with jets     one step of Newton's from that root, with the light and the OTF of that very range

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "apps/study/design/design_light.h"
#include "apps/study/design/metric_values.h"
#include "mtf/words.h"
#include "radiometry/performance/target_at_range.h"

namespace study {

/// An OTF along both axes, to that tolerance.
inline mtf::ResolutionNeeds curves_alone(double tolerance) {
  mtf::ResolutionNeeds needs;
  needs.curves = true;
  needs.tolerance = tolerance;
  return needs;
}

/// How far a design gets at a task.
struct RangeRoot {
  radiometry::AcquisitionRange found{};
  bool at_nyquist = false;   ///< it ends where the cycles that the task needs reach the Nyquist frequency
  bool fills_field = false;  ///< the target is wider there than the field of view, of which the models know nothing
  double slope = 0.0;        ///< of the margin, by ln(range)
  double error = 0.0;        ///< of the range, relative
  std::string refusal{};     ///< why there is none, the range being NaN; "" where there is
};
using RangeRoots = std::array<RangeRoot, kRangeTasks>;

/// Where a target is as wide as the narrower side of the field of view; 0 for a frame without a format.
template <class S>
double range_filling_the_field_m(const mtf::Frame<S>& frame, double size_m) {
  const double side_mm =
      1e-3 * std::min(frame.columns * mtf::value_of(frame.pitch_x_um), frame.rows * mtf::value_of(frame.pitch_y_um));
  return side_mm > 0.0 ? size_m * mtf::value_of(frame.focal_length_mm) / side_mm : 0.0;
}

/// What a target at a range offers to the observers of a design.
template <class S>
class RangeModel {
 public:
  using Sensor = radiometry::SensorAtRange<S>;
  using MakeBudget = std::function<radiometry::Budget<S>(const radiometry::SpectralNumbers<double>&)>;

  RangeModel(mtf::System<S>& system, const Conditions& conditions, const S& frame_time_s, LightCourse& course,
             mtf::ResolutionMeter<S>& meter, MakeBudget budget)
      : system_(&system),
        conditions_(&conditions),
        frame_time_s_(frame_time_s),
        course_(&course),
        meter_(&meter),
        budget_(std::move(budget)),
        bars_(system, conditions, frame_time_s) {
    const mtf::Context<S> shortest = system.band ? system.context(S(system.band->lo_um)) : system.context();
    for (const mtf::Entry<S>& entry : system.list(mtf::Stage::presample))
      cutoff_cy_mm_ = std::min(cutoff_cy_mm_, entry.component.cutoff_cy_mm(shortest));
  }

  /// With the light and the OTF of that range; 0 m: without air.
  Sensor at(double range_m) {
    const auto curves = std::make_shared<const mtf::Resolution<S>>(measured(course_->colour_at(range_m), *meter_));
    return behind(course_->at(range_m), range_m, seen(curves));
  }
  /// ln(what the target offers / what the task needs).
  S margin(const RangeTask& task, const Sensor& sensor, double range_m) {
    const S size(*conditions_->target_size_m), contrast(*conditions_->contrast_k);
    if (task.by_bars)
      return bars_.log_visibility(sensor, contrast, 1e-3 * task.cycles * range_m / *conditions_->target_size_m);
    return display().log_cycles(sensor, contrast, size, range_m) - S(std::log(task.cycles));
  }
  /// The cycles that the task needs are at the Nyquist frequency there.
  S nyquist_range_m(const RangeTask& task) const {
    return S(1e3 * *conditions_->target_size_m / task.cycles) * bars_.nyquist_cy_mrad();
  }
  /// The cycles that are resolved on the target at a range: along the finest bars up to Nyquist that it shows, or V.
  S cycles(bool by_bars, const Sensor& sensor, double range_m) {
    const double size_m = *conditions_->target_size_m;
    const S contrast(*conditions_->contrast_k);
    if (!by_bars) return radiometry::cycles_on_target(display().ttp_cy_mrad(sensor, contrast), S(size_m), S(range_m));
    constexpr double kCoarsest = 1e-6;  // of Nyquist
    const double nyquist = mtf::value_of(bars_.nyquist_cy_mrad());
    const auto finest =
        radiometry::longest_range([&](double f) { return mtf::value_of(bars_.log_visibility(sensor, contrast, f)); },
                                  kCoarsest * nyquist, nyquist, 0.5 * nyquist);
    return S(1e3 * finest.range_m * size_m / range_m);
  }
  double filled_m() const { return range_filling_the_field_m(system_->frame, *conditions_->target_size_m); }
  S ttp_cy_mrad(const Sensor& sensor) { return display().ttp_cy_mrad(sensor, S(*conditions_->contrast_k)); }

  /// The OTF along both axes with the colours of a range.
  mtf::Resolution<S> measured(const ColourAtRange& colour, mtf::ResolutionMeter<S>& meter) {
    const auto own_air = system_->air;
    const auto own_rate = system_->band ? system_->band->rate : nullptr;
    const auto scalar = [](const std::optional<double>& v) { return v ? std::optional<S>(*v) : std::nullopt; };
    if (system_->band) system_->band->rate = colour.rate;
    system_->air = {scalar(colour.air.path_length_m), scalar(colour.air.scattering)};
    mtf::Resolution<S> resolution = meter.measure(*system_);
    if (system_->band) system_->band->rate = own_rate;
    system_->air = own_air;
    return resolution;
  }
  radiometry::SeenOtf<S> seen(std::shared_ptr<const mtf::Resolution<S>> curves) const {
    return radiometry::seen_otf(std::move(curves), system_->frame);
  }
  S cy_mm(double f_cy_mrad) const { return system_->frame.cy_mm_from_mrad(S(f_cy_mrad)); }
  Sensor behind(const LightAtRange& light, double range_m, radiometry::SeenOtf<S> otf) const {
    const radiometry::Budget<S> budget = budget_(course_->numbers(light));
    if (budget.saturation.saturated())
      throw mtf::UsageError("with the light at " + mtf::significant(range_m, 15) + " m: " + words(budget.saturation));
    if (!budget.dither.dithered()) throw mtf::UsageError(words(budget.dither));
    return sensor_at_range(budget, S(light.contrast_share), std::move(otf));
  }
  const Conditions& conditions() const { return *conditions_; }
  LightCourse& course() { return *course_; }
  double counted_cy_mrad() const { return radiometry::counted_cy_mrad(*system_, cutoff_cy_mm_); }

 private:
  const radiometry::DisplayObserver<S>& display() {
    if (!display_) display_.emplace(*system_, *conditions_, frame_time_s_, counted_cy_mrad());
    return *display_;
  }

  mtf::System<S>* system_;
  const Conditions* conditions_;
  S frame_time_s_;
  LightCourse* course_;
  mtf::ResolutionMeter<S>* meter_;
  MakeBudget budget_;
  radiometry::BarObserver<S> bars_;
  std::optional<radiometry::DisplayObserver<S>> display_{};
  double cutoff_cy_mm_ = mtf::kInfinity;
};

/// MRTD and MDTD of a design behind its own air, at the scene; it has a budget and the curves of its OTF. Throws
/// UsageError for rounding that no noise dithers.
template <class S>
void observe_bars(Design<S>& design) {
  if (!design.budget->dither.dithered()) throw mtf::UsageError(words(design.budget->dither));
  const mtf::System<S>& system = *design.system;
  const radiometry::BarObserver<S> bars(system, *design.conditions, design.frame_time_s);
  const radiometry::SensorAtRange<S> sensor = sensor_at_range(
      *design.budget, S(1),
      radiometry::seen_otf(std::make_shared<const mtf::Resolution<S>>(design.resolution), system.frame));
  // At half of Nyquist, and of a square as wide as a bar there; both move with pitch and focal length.
  const S nyquist = bars.nyquist_cy_mrad(), width = S(1) / nyquist;
  const double middle = 0.5 * mtf::value_of(nyquist), square = mtf::value_of(width);
  design.observed.mrtd_k = radiometry::continued([&](double f) { return bars.mrtd_k(sensor, f); }, middle,
                                                 S(S(0.5) * nyquist), 1e-3 * middle);
  const double cutoff = radiometry::counted_cy_mrad(system, design.resolution.cutoff_cy_mm);
  design.observed.mdtd_k =
      radiometry::continued([&](double w) { return bars.mdtd_k(sensor, w, cutoff); }, square, width, 1e-3 * square);
}

/// The range of a root with its derivatives; NaN where there is none, 0 where the task succeeds nowhere.
template <class S>
S range_of(const RangeTask& task, const RangeRoot& root, RangeModel<S>& model) {
  if (root.found.reached == radiometry::Reached::never) return S(root.found.range_m);
  if (root.at_nyquist) return model.nyquist_range_m(task);
  const double range_m = root.found.range_m;
  return radiometry::range_with_slopes(range_m, model.margin(task, model.at(range_m), range_m), root.slope);
}

// The roots of a design's ranges. The OTF at the points of the panels is kept from one design to the next where both
// have the same. It is taken to a tolerance that ends half decades: first to a loose one, and where the errors of the
// ranges ask for it once more.

class RangeSolver {
 public:
  /// `asked`: which of range_tasks(). A task has no range where the air is not known that far or a model refuses it.
  /// `same_otf`: as at the call before. `tolerance`: relative, of the ranges.
  RangeRoots solve(RangeModel<double>& model, const std::shared_ptr<LightCourse>& course,
                   const std::array<bool, kRangeTasks>& asked, bool same_otf, double tolerance);

  /// What is resolved on the target at a range within the reach of the air, and what is left of it where everything
  /// is worse by what it may err. Of the design whose ranges were solved last.
  struct Resolved {
    double cycles = 0.0, least = 0.0;  ///< NaN where a model refuses the range
  };
  Resolved resolved(RangeModel<double>& model, bool by_bars, double range_m);

 private:
  using Curves = std::shared_ptr<const mtf::Resolution<double>>;
  using Sensor = radiometry::SensorAtRange<double>;

  RangeRoots roots_of(RangeModel<double>& model, const std::array<bool, kRangeTasks>& asked);
  RangeRoot root_of(const RangeTask& task, RangeModel<double>& model, double guess_m);
  Sensor frozen(RangeModel<double>& model, double range_m);
  Sensor followed(RangeModel<double>& model, double range_m);
  /// The OTF of a range between those at the points of the panel; null where these have panels of their own.
  static Curves between(const std::vector<Curves>& curves, const std::vector<double>& weight);
  struct Point;
  const Point& point_at(RangeModel<double>& model, const RangePanel* panel, std::size_t k);
  std::vector<Curves> curves_of(RangeModel<double>& model, const RangePanel& panel);
  static double error_between(const std::vector<Curves>& curves, double end_cy_mm);
  Sensor worst(RangeModel<double>& model, Sensor sensor, double range_m);

  std::shared_ptr<LightCourse> course_{};
  int half_decades_ = 0;  ///< the tolerance of the OTF is 10^-(half decades / 2)
  /// A meter keeps what it makes of the wavelengths of a colour, which costs more than the OTF.
  struct Point {
    mtf::ResolutionMeter<double> meter;
    Curves curves{};
    radiometry::SeenOtf<double> seen{};  ///< of the curves
  };
  /// By half decades, panel (null: without air) and point.
  std::map<std::tuple<int, const RangePanel*, std::size_t>, Point> points_{};
};

}  // namespace study
