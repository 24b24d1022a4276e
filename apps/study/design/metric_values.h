// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of metrics for one design and any scalar: resolution, budget and ranges of the design in, a number out. NaN
// where the design has none; the reason is given once for a study, see gaps of evaluator.h.

#include <algorithm>
#include <limits>

#include "apps/study/design/metric_rows.h"
#include "mtf/metrics/resolution.h"
#include "mtf/otf/otf_parts.h"
#include "radiometry/performance/giqe.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/performance/target_at_range.h"

namespace study {

namespace detail {

template <class S>
S not_there() {
  return S(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace detail

/// What observers make of the sensor; NaN where nothing has been found.
template <class S>
struct Observed {
  S mrtd_k = detail::not_there<S>(), mdtd_k = mrtd_k, ttp_cy_mrad = mrtd_k;
  std::array<S, kRangeTasks> range_m{mrtd_k, mrtd_k, mrtd_k, mrtd_k, mrtd_k, mrtd_k};  ///< of range_tasks()
};

template <class S>
struct Design {
  const mtf::System<S>* system = nullptr;
  const Conditions* conditions = nullptr;
  S range_m{};       ///< to the target; NaN where nothing says it
  S frame_time_s{};  ///< from one frame to the next
  mtf::Resolution<S> resolution{};
  std::optional<radiometry::Budget<S>> budget{};
  S noise_gain{1};  ///< of what follows the read noise: root of the mean of |OTF|^2 over the band, for GIQE
  Observed<S> observed{};
};

namespace detail {

template <class S>
S geometric_mean(const S& x, const S& y) {
  using std::sqrt;
  if (mtf::value_of(x) == mtf::value_of(y)) return S(0.5) * (x + y);  // also where both are 0 or negative
  const S product = x * y;
  return mtf::value_of(product) > 0.0 ? S(sqrt(product)) : mtf::value_of(product) == 0.0 ? S(0) : not_there<S>();
}

template <class S>
S ifov_urad(const Design<S>& d, mtf::Axis axis) {
  return d.system->frame.pitch_um(axis) * S(1e3) / d.system->frame.focal_length_mm;
}

template <class S>
S gsd_m(const Design<S>& d, mtf::Axis axis) {
  return radiometry::ground_sample_distance_m(d.system->frame.pitch_um(axis), d.system->frame.focal_length_mm,
                                              d.range_m);
}

template <class S>
S fov_deg(const Design<S>& d, mtf::Axis axis) {
  using std::atan;
  const int pixels = axis == mtf::Axis::x ? d.system->frame.columns : d.system->frame.rows;
  if (pixels <= 0) return not_there<S>();
  const S half = S(0.5e-3 * pixels) * d.system->frame.pitch_um(axis) / d.system->frame.focal_length_mm;
  return S(360.0 / mtf::kPi) * atan(half);
}

/// lambda N / pitch, of the pupil and the middle of the band.
template <class S>
S q_of(const Design<S>& d, mtf::Axis axis) {
  for (const mtf::Entry<S>& entry : d.system->list(mtf::Stage::presample))
    if (entry.component.is_pupil()) {
      const mtf::PupilNumbers<S> pupil = mtf::pupil_numbers(entry.component, d.system->context());
      return pupil.wavelength_um * pupil.f_number / d.system->frame.pitch_um(axis);
    }
  return not_there<S>();
}

/// The optical cutoff at the shortest wavelength that gets there, or where a curve is 0 before.
template <class S>
S cutoff_cy_mm(const Design<S>& d) {
  const double end = d.resolution.cutoff_cy_mm;
  if (!(end < mtf::kInfinity)) return not_there<S>();
  for (const mtf::Entry<S>& entry : d.system->list(mtf::Stage::presample))
    if (entry.component.is_pupil()) {
      const mtf::System<S>& system = *d.system;
      const auto context = system.band ? system.context(S(system.band->lo_um)) : system.context();
      const mtf::PupilNumbers<S> pupil = mtf::pupil_numbers(entry.component, context);
      const S cutoff = S(1e3) / (pupil.wavelength_um * pupil.f_number);
      constexpr double kSame = 1.0 - 1e-9;
      return end < kSame * mtf::value_of(cutoff) ? S(end) : cutoff;
    }
  return S(end);
}

/// The member that stands for a metric; NaN without one.
template <class S, class Figures, std::size_t N>
S member_of(const std::array<std::pair<Metric, S Figures::*>, N>& members, Metric metric, const Figures& figures) {
  const auto found = std::ranges::find(members, metric, &std::pair<Metric, S Figures::*>::first);
  return found != members.end() ? figures.*found->second : not_there<S>();
}

template <class S>
S axis_value(Metric metric, const mtf::AxisFigures<S>& f, std::size_t at) {
  using F = mtf::AxisFigures<S>;
  constexpr std::array kMembers{std::pair{Metric::optics_mtf_nyquist, &F::optics_nyquist},
                                std::pair{Metric::detector_mtf_nyquist, &F::detector_nyquist},
                                std::pair{Metric::presample_mtf_nyquist, &F::presample_nyquist},
                                std::pair{Metric::mtf_nyquist, &F::nyquist},
                                std::pair{Metric::folded_mtf_nyquist, &F::folded_nyquist},
                                std::pair{Metric::mtf50, &F::mtf50_cy_px},
                                std::pair{Metric::mtfa, &F::mtfa},
                                std::pair{Metric::rer, &F::rer},
                                std::pair{Metric::edge_overshoot, &F::overshoot},
                                std::pair{Metric::edge_height, &F::edge_height},
                                std::pair{Metric::fwhm, &F::fwhm_px},
                                std::pair{Metric::aliasing_ratio, &F::aliasing},
                                std::pair{Metric::spurious_in_band, &F::spurious_in},
                                std::pair{Metric::spurious_out_of_band, &F::spurious_out}};
  if (metric == Metric::mtf_at) return f.mtf_at[at];
  if (metric == Metric::spurious_response) return f.spurious_in + f.spurious_out;
  return member_of(kMembers, metric, f);
}

template <class S>
S along(const Design<S>& d, const MetricRow& row, mtf::Axis axis, std::size_t at) {
  if (row.metric == Metric::nyquist) return d.system->frame.nyquist_cy_mm(axis);
  if (row.metric == Metric::ifov) return ifov_urad(d, axis);
  if (row.metric == Metric::gsd) return gsd_m(d, axis);
  if (row.metric == Metric::fov) return fov_deg(d, axis);
  if (row.metric == Metric::q) return q_of(d, axis);
  return axis_value(row.metric, axis == mtf::Axis::x ? d.resolution.x : d.resolution.y, at);
}

/// The target's contrast in the frames over the noise of its background: the difference that a surface so much warmer
/// makes, or a share of the scene's electrons. Throws UsageError where an end of the range holds the target.
template <class S>
S target_snr(const Design<S>& d) {
  if (!d.budget) return not_there<S>();
  const radiometry::Budget<S>& b = *d.budget;
  const Conditions& conditions = *d.conditions;
  if (!conditions.contrast_k && !conditions.signal_contrast) return not_there<S>();
  const S more_e =
      conditions.contrast_k ? b.contrast_e : S(S(*conditions.signal_contrast) * b.contrast_share * b.signal.scene_e);
  if (b.saturation.saturated()) return not_there<S>();
  if (const radiometry::Saturation held = target_saturation(b, more_e); held.saturated())
    throw mtf::UsageError("the target of [conditions] is " + words(held));
  return seen_difference(b, more_e) / b.temporal_e;
}

template <class S>
S budget_value(Metric metric, const radiometry::Budget<S>& b) {
  using B = radiometry::Budget<S>;
  constexpr std::array kMembers{std::pair{Metric::well_fill, &B::well_fill},
                                std::pair{Metric::scene_shot_noise, &B::scene_shot_e},
                                std::pair{Metric::background_shot_noise, &B::background_shot_e},
                                std::pair{Metric::dark_shot_noise, &B::dark_shot_e},
                                std::pair{Metric::read_noise, &B::read_e},
                                std::pair{Metric::reset_noise, &B::reset_e},
                                std::pair{Metric::other_noise, &B::other_e},
                                std::pair{Metric::quantisation_noise, &B::quantisation_e},
                                std::pair{Metric::temporal_noise, &B::temporal_e},
                                std::pair{Metric::prnu_noise, &B::prnu_e},
                                std::pair{Metric::dsnu_noise, &B::dsnu_e},
                                std::pair{Metric::correction_noise, &B::correction_e},
                                std::pair{Metric::spatial_noise, &B::spatial_e},
                                std::pair{Metric::snr, &B::snr},
                                std::pair{Metric::nei, &B::nei_ph},
                                std::pair{Metric::dynamic_range, &B::dynamic_range}};
  if (metric == Metric::signal) return b.signal.scene_e;
  if (metric == Metric::background) return b.signal.path_e + b.signal.optics_e + b.signal.stop_e + b.signal.dark_e;
  if (metric == Metric::netd) return S(1e3) * b.netd_k;
  if (metric == Metric::shot_netd) return S(1e3) * b.shot_netd_k;
  if (metric == Metric::spatial_netd) return S(1e3) * b.spatial_netd_k;
  if (metric == Metric::nep) return S(1e12) * b.nep_w;
  return member_of(kMembers, metric, b);
}

/// A rating; the scale goes from 0 to 9, and the equations go on outside of it.
template <class S>
S rated(const S& niirs) {
  const double value = mtf::value_of(niirs);
  if (value < 0.0 || value > 9.0)
    throw mtf::UsageError("NIIRS of " + mtf::three_digits(value) + ": the scale goes from 0 to 9, and the equation " +
                          "(a regression on ratings) says nothing of images " + (value < 0.0 ? "below" : "above") +
                          " it");
  return niirs;
}

template <class S>
S niirs(Metric metric, const Design<S>& d) {
  const S gsd = geometric_mean(gsd_m(d, mtf::Axis::x), gsd_m(d, mtf::Axis::y)), snr = target_snr(d);
  const mtf::AxisFigures<S>&x = d.resolution.x, &y = d.resolution.y;
  const bool there =
      mtf::value_of(gsd) > 0.0 && mtf::value_of(snr) > 0.0 && mtf::value_of(x.rer) > 0.0 && mtf::value_of(y.rer) > 0.0;
  constexpr double kNoSignal = 1e-3;  // the equation would go on falling without end
  if (mtf::value_of(snr) < kNoSignal)
    throw mtf::UsageError("NIIRS: the signal-to-noise ratio of the target is " +
                          mtf::format_double(mtf::value_of(snr)) +
                          ": its surface at [conditions] temperature gives no light in this band; in sunlight give the "
                          "temperature of the sun, 5800 K");
  if (!there) return not_there<S>();
  const S elevation(d.conditions->elevation_deg);
  if (metric == Metric::niirs_giqe5)
    return radiometry::niirs_giqe5<S>({gsd, x.rer_unfiltered, y.rer_unfiltered, snr, elevation});
  const radiometry::Giqe4Input<S> in{
      gsd, geometric_mean(x.rer, y.rer), geometric_mean(x.edge_height, y.edge_height), d.noise_gain, snr, elevation};
  return metric == Metric::niirs_giqe3 ? radiometry::niirs_giqe3(in) : radiometry::niirs_giqe4(in);
}

/// System MTF along an axis at f in cycles/mrad.
template <class S>
S mtf_at_mrad(const Design<S>& d, mtf::Axis axis, double f_cy_mrad) {
  const S f = d.system->frame.cy_mm_from_mrad(S(f_cy_mrad));
  return (axis == mtf::Axis::x ? d.resolution.curve_x : d.resolution.curve_y).modulus(f);
}

template <class S>
S grd_m(const Design<S>& d) {
  const S snr = target_snr(d);
  if (!(mtf::value_of(d.range_m) > 0.0) || !(mtf::value_of(snr) > 0.0)) return not_there<S>();
  S worst(0);
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y}) {
    const radiometry::GrdInput<S> in{snr, S(1e-3) * ifov_urad(d, axis), d.range_m};
    const S grd = radiometry::ground_resolved_distance(in, [&](double f) { return mtf_at_mrad(d, axis, f); }).grd_m;
    if (mtf::value_of(grd) > mtf::value_of(worst)) worst = grd;
  }
  if (!(mtf::value_of(worst) < mtf::kInfinity))
    throw mtf::UsageError("grd: the MTF is nowhere 3 / the signal-to-noise ratio of the target, " +
                          mtf::three_digits(mtf::value_of(snr)));
  return worst;
}

template <class S>
S observed_value(Metric metric, const Observed<S>& o) {
  if (metric == Metric::mrtd) return S(1e3) * o.mrtd_k;
  if (metric == Metric::mdtd) return S(1e3) * o.mdtd_k;
  if (metric == Metric::ttp) return o.ttp_cy_mrad;
  const std::array<RangeTask, kRangeTasks> tasks = range_tasks(Conditions{});
  for (std::size_t i = 0; i < tasks.size(); ++i)
    if (tasks[i].metric == metric) return o.range_m[i];
  return not_there<S>();
}

}  // namespace detail

/// The value in the unit of the row. `at`: which of ResolutionNeeds::at, for mtf_at. NaN where the design has none.
template <class S>
S metric_value(const MetricChoice& choice, const Design<S>& d, std::size_t at) {
  using namespace detail;
  const MetricRow& row = *choice.row;
  const auto finite = [](const S& value) { return std::isfinite(mtf::value_of(value)) ? value : not_there<S>(); };
  if (row.directional) {
    if (choice.axis) return finite(along(d, row, *choice.axis, at));
    // What lies below 0 where nothing overshoots has a mean of the edge itself.
    const S shift(row.metric == Metric::edge_overshoot ? 1.0 : 0.0);
    return finite(
        geometric_mean(S(along(d, row, mtf::Axis::x, at) + shift), S(along(d, row, mtf::Axis::y, at) + shift)) - shift);
  }
  if (row.metric == Metric::cutoff) return cutoff_cy_mm(d);
  if (row.metric == Metric::strehl) return d.resolution.strehl;
  if (row.metric == Metric::ensquared_energy) return d.resolution.ensquared;
  if (row.metric == Metric::target_snr) return finite(target_snr(d));
  if (row.effort == Effort::giqe) return rated(finite(niirs(row.metric, d)));
  if (row.metric == Metric::grd) return grd_m(d);
  if (row.effort == Effort::bars && std::isinf(mtf::value_of(observed_value(row.metric, d.observed))))
    throw mtf::UsageError(std::string(row.name) + ": " + radiometry::kNotResolved);
  if (row.effort == Effort::bars || row.effort == Effort::air) return finite(observed_value(row.metric, d.observed));
  return d.budget ? finite(budget_value(row.metric, *d.budget)) : not_there<S>();
}

}  // namespace study
