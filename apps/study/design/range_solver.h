// SPDX-License-Identifier: Apache-2.0
#pragma once

// The roots of a design's ranges. The OTF at the points of the panels is kept from one design to the next where both
// have the same. It is taken to a tolerance that ends half decades: first to a loose one, and where the errors of the
// ranges ask for it once more.

#include <map>
#include <tuple>
#include <vector>

#include "apps/study/design/design_ranges.h"

namespace study {

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
