// SPDX-License-Identifier: Apache-2.0
#pragma once

// MRTD, MDTD, ranges by Johnson's criteria and by TTP for a design, from its budget and its OTF. Noise enters as the
// NETD (temporal) and the spatial NETD of the budget; the observer in front of the display is that of [conditions]. As
// published (FLIR92, TR-230) these models are linear in the contrast: a temperature difference over NETDs, slopes at
// the temperature of the background; at 4 K and 3 to 5 um the target's electrons are some 7 % more than that. The
// contrast falls with range by [conditions] extinction alone: a [path] in the sensor file belongs to the budget.

#include "apps/study/design/metric_values.h"
#include "radiometry/performance/contrast_threshold.h"
#include "radiometry/performance/johnson.h"
#include "radiometry/performance/mdtd.h"
#include "radiometry/performance/ttp.h"

namespace study {

namespace detail {

/// A smooth, positive function of a frequency as a Chebyshev series of its logarithm over that of the frequency.
template <class S>
class LogSeries {
 public:
  /// Over 20 octaves up to `end`; beyond them the ends count. Functions that the eye's channel has smoothed are known
  /// to 1e-9 by 65 values.
  template <class Function>
  LogSeries(double end, const Function& function) : hi_(std::log(end)), lo_(std::log(end) - 20.0 * std::log(2.0)) {
    using std::log;
    constexpr int kDegree = mtf::kMostDegree;
    for (int k = 0; k <= kDegree; ++k)
      series_.push_back(log(function(std::exp(at(mtf::cos_pi(static_cast<double>(k) / kDegree))))));
    mtf::chebyshev_coefficients(series_);
  }
  S operator()(double f) const {
    using std::exp;
    const double t = (std::log(std::max(f, 1e-300)) - lo_) / (hi_ - lo_) * 2.0 - 1.0;
    return exp(mtf::chebyshev(series_, std::clamp(t, -1.0, 1.0)));
  }

 private:
  double at(double t) const { return lo_ + 0.5 * (t + 1.0) * (hi_ - lo_); }
  double hi_, lo_;
  std::vector<S> series_;
};

}  // namespace detail

/// `design` has a budget; ranges stay NaN without contrast and size of the target.
template <class S>
RangeFigures<S> range_figures(const Design<S>& design) {
  using mtf::Axis;
  using std::sqrt;
  const Conditions& c = *design.conditions;
  const mtf::System<S>& system = *design.system;
  const radiometry::Budget<S>& b = *design.budget;
  RangeFigures<S> figures;
  figures.ttp_cy_mrad = detail::not_there<S>();
  for (int i = 0; i < 3; ++i) figures.johnson_m[i] = figures.ttp_m[i] = detail::not_there<S>();

  const S frame_rate = c.frame_rate_hz > 0.0 ? S(c.frame_rate_hz) : S(S(1) / design.frame_time_s);
  radiometry::MrtdInput<S> in{.tvh_k = b.netd_k, .vh_k = b.spatial_netd_k};
  in.spacing_x_mrad = S(1e-3) * detail::ifov_urad(design, Axis::x);
  in.spacing_y_mrad = S(1e-3) * detail::ifov_urad(design, Axis::y);
  in.snr_threshold = S(c.snr_threshold);
  in.eye_time_s = S(c.eye_time_s);
  in.frame_rate_hz = frame_rate;
  // What follows sampling filters the noise.
  const auto after = [&](Axis axis) {
    return [&system, axis](double f_cy_mrad) {
      const S f = system.frame.cy_mm_from_mrad(S(f_cy_mrad));
      const mtf::Freq<S> at = axis == Axis::x ? mtf::Freq<S>{f, S(0)} : mtf::Freq<S>{S(0), f};
      const mtf::Complex<S> h = system.otf(mtf::Stage::readout, at) * system.otf(mtf::Stage::postsample, at);
      const S square = h.re * h.re + h.im * h.im;
      return mtf::value_of(square) > 0.0 ? S(sqrt(square)) : S(0);
    };
  };
  const auto whole = [&](Axis axis) {
    return [&design, axis](double f_cy_mrad) { return detail::mtf_at_mrad(design, axis, f_cy_mrad); };
  };
  const auto mrtd = [&](Axis axis) {
    return [&, axis](double f) { return radiometry::mrtd_k(in, axis, f, whole(axis), after(Axis::x), after(Axis::y)); };
  };
  const S nyquist = S(0.5) / detail::geometric_mean(in.spacing_x_mrad, in.spacing_y_mrad);
  const auto both = [&](double f) { return radiometry::mrtd_2d_k<S>(f, mrtd(Axis::x), mrtd(Axis::y)); };
  // At half of Nyquist, which moves with pitch and focal length.
  const double middle = 0.5 * mtf::value_of(nyquist);
  figures.mrtd_k = radiometry::continued(both, middle, S(S(0.5) * nyquist), 1e-3 * middle);
  const double cutoff = design.resolution.cutoff_cy_mm < mtf::kInfinity
                            ? mtf::value_of(system.frame.cy_per_mrad(S(design.resolution.cutoff_cy_mm)))
                            : 4.0 * mtf::value_of(nyquist);
  // A square as wide as a bar there; its width moves with pitch and focal length too.
  const S width = S(1) / nyquist;
  const double square = mtf::value_of(width);
  const auto detected = [&](double w) {
    return radiometry::mdtd_k(in, w, S(cutoff), whole(Axis::x), whole(Axis::y), after(Axis::x), after(Axis::y));
  };
  figures.mdtd_k = radiometry::continued(detected, square, width, 1e-3 * square);
  if (!c.contrast_k) return figures;

  constexpr std::array<double, 3> kN50{0.75, 3.0, 6.0};
  if (c.target_size_m)
    for (std::size_t i = 0; i < 3; ++i) {
      const radiometry::JohnsonTask<S> task{.size_m = S(*c.target_size_m),
                                            .contrast_k = S(*c.contrast_k),
                                            .extinction_per_km = S(c.extinction_per_km),
                                            .n50 = S(kN50[i])};
      figures.johnson_m[i] = radiometry::johnson_range(task, both, nyquist).range_m;
    }

  radiometry::Observer<S> observer;
  observer.luminance_cd_m2 = S(c.luminance_cd_m2);
  observer.magnification = S(c.viewing_magnification);
  radiometry::require_valid("observer", observer);
  const S scene_k(c.scene_contrast_k);
  // Fixed noise is not averaged over the frames that the eye adds up.
  const S frames = frame_rate * S(c.eye_time_s);
  const S kept = mtf::value_of(frames) > 1.0 ? frames : S(1);
  const S rms_k = radiometry::detail::root(S(b.netd_k * b.netd_k + kept * b.spatial_netd_k * b.spatial_netd_k));
  const S density = radiometry::noise_density(rms_k, in.spacing_x_mrad, in.spacing_y_mrad, frame_rate);
  const auto seen = [&](Axis axis) {  // what filters the noise between the readout and the retina
    return [&, axis](double f) { return S(after(axis)(f) * radiometry::eye_mtf_at(observer, S(f))); };
  };
  const double eye_end = 8.0 * c.viewing_magnification;  // cycles/mrad: the eye's MTF is below 1e-12 there
  const S across_x = radiometry::bandwidth<S>(eye_end, seen(Axis::x));
  const S across_y = radiometry::bandwidth<S>(eye_end, seen(Axis::y));
  const auto along = [&](Axis axis) {
    return detail::LogSeries<S>(cutoff, [&](double f) { return radiometry::channel_bandwidth<S>(f, seen(axis)); });
  };
  const detail::LogSeries<S> along_x = along(Axis::x), along_y = along(Axis::y);
  const auto sensitivity = [&](Axis axis) {
    return [&, axis](double f) {
      const bool on_x = axis == Axis::x;
      const S factor = radiometry::noise_factor(S(radiometry::kAlphaNvThermIp), density, on_x ? along_x(f) : along_y(f),
                                                on_x ? across_y : across_x, scene_k);
      return radiometry::system_sensitivity(observer, f, whole(axis)(f), factor);
    };
  };
  const auto x = sensitivity(Axis::x), y = sensitivity(Axis::y);
  const radiometry::SensitivityCourse course_x = radiometry::sensitivity_course(x, cutoff),
                                      course_y = radiometry::sensitivity_course(y, cutoff);
  const S contrast = S(0.5 * *c.contrast_k) / scene_k;
  figures.ttp_cy_mrad =
      radiometry::ttp_of(radiometry::axis_ttp(course_x, x, contrast), radiometry::axis_ttp(course_y, y, contrast));
  if (!c.target_size_m) return figures;
  const std::array<double, 3> v50{c.v50_detect, c.v50_recognise, c.v50_identify};
  for (std::size_t i = 0; i < 3; ++i) {
    const radiometry::TtpTask<S> task{.size_m = S(*c.target_size_m),
                                      .contrast = contrast,
                                      .extinction_per_km = S(c.extinction_per_km),
                                      .v50 = S(v50[i])};
    figures.ttp_m[i] = radiometry::ttp_range(task, course_x, x, course_y, y).range_m;
  }
  return figures;
}

}  // namespace study
