// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/observer_rows.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/otf_curves.h"
#include "mtf/error.h"
#include "radiometry/performance/mdtd.h"

namespace apps {
namespace {

using mtf::Axis;

/// Values from 0 to `end` in even steps, and between them the cubic through the four next to it; 0 beyond the end.
class EvenCurve {
 public:
  EvenCurve(std::vector<double> values, double end) : values_(std::move(values)), end_(end) {}
  double operator()(double f) const {
    if (!(f <= end_)) return 0.0;
    const auto last = static_cast<std::ptrdiff_t>(values_.size()) - 1;
    const double place = f / end_ * static_cast<double>(last);
    const std::ptrdiff_t i = std::min(static_cast<std::ptrdiff_t>(place), last - 1);
    const double t = place - static_cast<double>(i);
    // The modulus is even about 0; beyond the end the last step goes on.
    const auto at = [&](std::ptrdiff_t k) { return values_[static_cast<std::size_t>(std::min(std::abs(k), last))]; };
    const double before = at(i - 1), a = at(i), b = at(i + 1), after = at(i + 2);
    return -t * (t - 1.0) * (t - 2.0) / 6.0 * before + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * a -
           (t + 1.0) * t * (t - 2.0) / 2.0 * b + (t + 1.0) * t * (t - 1.0) / 6.0 * after;
  }

 private:
  std::vector<double> values_;
  double end_;
};

/// MTFs along an axis over cycles/mrad.
struct AxisMtf {
  EvenCurve whole;
  EvenCurve noise;  ///< of what follows the sampling
  double end;       ///< the cutoff of the optics, else four times Nyquist
};

AxisMtf axis_mtf(const mtf::System<double>& system, Axis axis) {
  constexpr int kCount = 513;
  const Direction direction = make_direction(system.frame, "cy/mrad", axis == Axis::x ? 0.0 : 90.0);
  const KeyFigures figures = key_figures(system, direction);
  const double end = std::max(figures.cutoff.value_or(4.0 * figures.nyquist), figures.nyquist);
  std::vector<mtf::Freq<double>> frequencies;
  for (const double f : evenly_spaced(0.0, end, kCount))
    frequencies.push_back({f * direction.step.x, f * direction.step.y});
  std::vector<double> noise(kCount, 1.0), whole;
  const auto multiply = [&](std::vector<double>& by, mtf::Stage stage) {
    const auto& list = system.list(stage);
    if (list.empty()) return;
    const auto otf = system.otf_with_error(std::span(list), frequencies).value;
    for (std::size_t i = 0; i < by.size(); ++i) by[i] *= std::hypot(otf[i].re, otf[i].im);
  };
  multiply(noise, mtf::Stage::readout);
  multiply(noise, mtf::Stage::postsample);
  whole = noise;
  multiply(whole, mtf::Stage::presample);
  return {{std::move(whole), end}, {std::move(noise), end}, end};
}

/// Why a sensor has neither, "" where it has both.
std::string gap_of(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                   const radiometry::Budget<double>& budget) {
  if (const std::string refused = refusal_of(budget, budget.netd_k); !refused.empty()) return refused;
  constexpr double kMost_k = 1e6;  // of MrtdInput
  if (!(budget.netd_k <= kMost_k && budget.spatial_netd_k <= kMost_k))
    return "the noise is no temperature difference: an NETD of " + mtf::three_digits(budget.netd_k) +
           " K and a spatial one of " + mtf::three_digits(budget.spatial_netd_k) + " K";
  if (!(system.frame.focal_length_mm > 0.0)) return "no [frame] focal_length";
  const auto& frame = sensor.settings.frame;
  if (sensor.settings.thermal && !(frame && frame->frame_time_s)) return "no [frame] frame_time";
  return "";
}

}  // namespace

std::vector<radiometry::BudgetRow> observer_rows(const mtf::System<double>& system, const radiometry::Sensor& sensor,
                                                 const radiometry::Budget<double>& budget) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  radiometry::BudgetRow mrtd{"mrtd", "mK", none, "minimum resolvable temperature difference at half of Nyquist, 2-D"},
      mdtd{"mdtd", "mK", none, "minimum detectable temperature difference of a square of 1 / Nyquist"};
  mrtd.refused = mdtd.refused = gap_of(system, sensor, budget);
  mrtd.saturated = mdtd.saturated = is_saturated(budget, budget.netd_k);
  if (!mrtd.refused.empty()) return {mrtd, mdtd};
  const auto& frame = sensor.settings.frame;
  const double frame_time_s =
      frame ? frame->frame_time_s.value_or(system.frame.integration_time_s) : system.frame.integration_time_s;
  const auto spacing_mrad = [&](Axis axis) { return system.frame.pitch_um(axis) / system.frame.focal_length_mm; };
  const radiometry::MrtdInput<double> in{.tvh_k = budget.netd_k,
                                         .vh_k = budget.spatial_netd_k,
                                         .spacing_x_mrad = spacing_mrad(Axis::x),
                                         .spacing_y_mrad = spacing_mrad(Axis::y),
                                         .frame_rate_hz = 1.0 / frame_time_s};
  try {
    const AxisMtf x = axis_mtf(system, Axis::x), y = axis_mtf(system, Axis::y);
    const auto along = [&](Axis axis) {
      return [&, axis](double f) {
        return radiometry::mrtd_k(in, axis, f, axis == Axis::x ? x.whole : y.whole, x.noise, y.noise);
      };
    };
    const double nyquist = 0.5 / std::sqrt(in.spacing_x_mrad * in.spacing_y_mrad);
    mrtd.value = 1e3 * radiometry::mrtd_2d_k<double>(0.5 * nyquist, along(Axis::x), along(Axis::y));
    mdtd.value =
        1e3 * radiometry::mdtd_k(in, 1.0 / nyquist, std::max(x.end, y.end), x.whole, y.whole, x.noise, y.noise);
    for (radiometry::BudgetRow* row : {&mrtd, &mdtd})
      if (!std::isfinite(row->value)) row->refused = "the MTF is 0 at that frequency";
  } catch (const mtf::Error& error) {
    mrtd.refused = mdtd.refused = error.what();
  }
  return {mrtd, mdtd};
}

}  // namespace apps
