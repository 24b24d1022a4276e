// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a target offers to an observer at one range, and by how much that is more than a task needs. Range enters in
// three ways: the target gets smaller, and the air behind which the sensor sees it takes contrast and adds light, whose
// noise counts, and blur.
//
// Temperature differences are apparent ones, at the aperture: a difference dT at the target arrives as
//   dT x (derivative of the scene's electrons by its temperature, behind the air)/(the same without air),
// and NETDs are noise over that derivative without air. Both are integrals over the band of scene x air x optics x
// response together. So the air's transmission counts once, in the contrast, and its light in the noise; behind air
// that only dims (Beer's law, extinction) the NETD stays what it is without air.
//
// Two models, linear in the contrast as published:
//   FLIR92, Johnson  bars whose MRTD (mrtd.h) is below the contrast are resolved; N cycles on a target of the size h
//                    succeed where MRTD(N R/h) < dT. Up to the Nyquist frequency. (Johnson, Image Intensifier
//                    Symposium, 249 (1958); Ratches, Opt. Eng. 15, 525 (1976); Kennedy, Proc. SPIE 1488 (1991),
//                    doi 10.1117/12.45802)
//   TR-230, TTP      C = dT/(2 S_tmp) against the threshold of the eye before the display (ttp.h),
//                    V = TTP(C) sqrt(A)/R. S_tmp is the apparent difference from dark to mean luminance of the display,
//                    which stays what it is when contrast is lost: nobody turns the gain up. Up to the optical cutoff.
//                    Fixed noise is not averaged over the frames that the eye adds up.
// Aliasing counts in neither.

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mtf/metrics/resolution.h"
#include "mtf/system.h"
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/conditions.h"
#include "radiometry/performance/contrast_threshold.h"
#include "radiometry/performance/mdtd.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/performance/ttp.h"

namespace radiometry {

/// The OTF of air, sensor and display along the axes, the eye excluded; f in cycles/mrad.
template <class S>
struct SeenOtf {
  std::function<S(mtf::Axis, double)> mtf{};
  std::function<S(mtf::Axis, double)> centred{};  ///< with its sign (OtfCurve::centred), for squares
  std::array<double, 2> reversal_cy_mrad{mtf::kInfinity, mtf::kInfinity};  ///< from there on bars are not resolved
};

/// Of curves that hold the frame's focal length.
template <class S>
SeenOtf<S> seen_otf(std::shared_ptr<const mtf::Resolution<S>> curves, const mtf::Frame<S>& frame) {
  const auto of = [curves](mtf::Axis axis) -> const mtf::OtfCurve<S>& {
    return axis == mtf::Axis::x ? curves->curve_x : curves->curve_y;
  };
  const auto reversal = [&](mtf::Axis axis) {
    return mtf::value_of(frame.cy_per_mrad(S(1))) * of(axis).reversal_cy_mm();
  };
  return {.mtf = [of, frame](mtf::Axis axis, double f) { return of(axis).modulus(frame.cy_mm_from_mrad(S(f))); },
          .centred = [of, frame](mtf::Axis axis, double f) { return of(axis).centred(frame.cy_mm_from_mrad(S(f))); },
          .reversal_cy_mrad = {reversal(mtf::Axis::x), reversal(mtf::Axis::y)}};
}

/// Why bars or a square are seen at no contrast.
inline constexpr const char* kNotResolved = "the MTF is 0 there, or the OTF has changed its sign before";

/// A sensor behind the air of one range.
template <class S>
struct SensorAtRange {
  S netd_k{}, spatial_netd_k{};  ///< at the aperture
  S contrast_share{1};           ///< what arrives there of a small temperature difference at the target
  SeenOtf<S> otf{};
  S late{}, late_spatial{};  ///< shares of both variances that come behind [[readout]], which does not filter them
};

/// The share of the variance of a whole that a part of it has.
template <class S>
S share_of_variance(const S& part, const S& whole) {
  return mtf::value_of(whole) > 0.0 ? S(part * part / (whole * whole)) : S(0);
}

template <class S>
SensorAtRange<S> sensor_at_range(const Budget<S>& b, const S& contrast_share, SeenOtf<S> otf) {
  return {b.netd_k,
          b.spatial_netd_k,
          contrast_share,
          std::move(otf),
          share_of_variance(b.late_temporal_e, b.temporal_e),
          share_of_variance(b.late_spatial_e, b.spatial_e)};
}

/// True when something follows the sampling, which filters noise.
template <class S>
bool filters_noise(const mtf::System<S>& system) {
  return !system.list(mtf::Stage::readout).empty() || !system.list(mtf::Stage::postsample).empty();
}
/// The modulus of what follows the sampling, or of what follows the readout alone; f in cycles/mrad.
template <class S>
S noise_mtf(const mtf::System<S>& system, mtf::Axis axis, double f_cy_mrad, bool late = false) {
  using std::sqrt;
  if (!filters_noise(system)) return S(1);
  const S f = system.frame.cy_mm_from_mrad(S(f_cy_mrad));
  const mtf::Freq<S> at = axis == mtf::Axis::x ? mtf::Freq<S>{f, S(0)} : mtf::Freq<S>{S(0), f};
  mtf::Complex<S> h = system.otf(mtf::Stage::postsample, at);
  if (!late) h = system.otf(mtf::Stage::readout, at) * h;
  const S square = h.re * h.re + h.im * h.im;
  return mtf::value_of(square) > 0.0 ? S(sqrt(square)) : S(0);
}

/// FLIR92's observer of bars and squares. It refers to the system, which has to outlive it.
template <class S>
class BarObserver {
 public:
  BarObserver(const mtf::System<S>& system, const Conditions& conditions, const S& frame_time_s) : system_(&system) {
    const auto spacing_mrad = [&](mtf::Axis axis) {
      return S(system.frame.pitch_um(axis) / system.frame.focal_length_mm);
    };
    input_.spacing_x_mrad = spacing_mrad(mtf::Axis::x);
    input_.spacing_y_mrad = spacing_mrad(mtf::Axis::y);
    input_.snr_threshold = S(conditions.snr_threshold);
    input_.eye_time_s = S(conditions.eye_time_s);
    input_.frame_rate_hz = conditions.frame_rate_hz ? S(*conditions.frame_rate_hz) : S(S(1) / frame_time_s);
  }

  /// Geometric mean of both axes.
  S nyquist_cy_mrad() const {
    using std::sqrt;
    return S(0.5) / S(sqrt(S(input_.spacing_x_mrad * input_.spacing_y_mrad)));
  }
  /// Of bars that alternate along an axis, infinite from where the OTF changes its sign.
  S mrtd_k(const SensorAtRange<S>& sensor, mtf::Axis axis, double f_cy_mrad) const {
    const double reversal = sensor.otf.reversal_cy_mrad[static_cast<std::size_t>(axis)];
    return of_noise(sensor, [&](const MrtdInput<S>& in, const auto& noise_x, const auto& noise_y) {
      return radiometry::mrtd_k(
          in, axis, f_cy_mrad, [&](double g) { return g < reversal ? sensor.otf.mtf(axis, g) : S(0); }, noise_x,
          noise_y);
    });
  }
  /// 2-D, f > 0.
  S mrtd_k(const SensorAtRange<S>& sensor, double f_cy_mrad) const {
    const auto along = [&](mtf::Axis axis) { return [&, axis](double f) { return mrtd_k(sensor, axis, f); }; };
    return mrtd_2d_k<S>(f_cy_mrad, along(mtf::Axis::x), along(mtf::Axis::y));
  }
  /// Of a square of that width; the OTF counts up to `cutoff`.
  S mdtd_k(const SensorAtRange<S>& sensor, double width_mrad, double cutoff_cy_mrad) const {
    const auto along = [&](mtf::Axis axis) { return [&, axis](double f) { return sensor.otf.centred(axis, f); }; };
    return of_noise(sensor, [&](const MrtdInput<S>& in, const auto& noise_x, const auto& noise_y) {
      return radiometry::mdtd_k(in, width_mrad, S(cutoff_cy_mrad), along(mtf::Axis::x), along(mtf::Axis::y), noise_x,
                                noise_y);
    });
  }
  /// ln(dT / MRTD) of bars of that frequency; -infinity where they are not resolved at any contrast.
  S log_visibility(const SensorAtRange<S>& sensor, const S& contrast_k, double f_cy_mrad) const {
    using std::log;
    const S ratio = contrast_k * sensor.contrast_share / mrtd_k(sensor, f_cy_mrad);
    return mtf::value_of(ratio) > 0.0 ? S(log(ratio)) : S(-mtf::kInfinity);
  }

 private:
  /// A minimum difference is linear in the noise, and noise before and behind the readout adds by its squares.
  template <class Minimum>
  S of_noise(const SensorAtRange<S>& sensor, const Minimum& minimum) const {
    const auto with = [&](const S& share, const S& spatial_share) {
      MrtdInput<S> in = input_;
      in.tvh_k = sensor.netd_k * detail::root(share);
      in.vh_k = sensor.spatial_netd_k * detail::root(spatial_share);
      return in;
    };
    const auto filtered = [&](const MrtdInput<S>& in, bool late) {
      const auto noise = [&](mtf::Axis axis) {
        return [this, axis, late](double f) { return noise_mtf(*system_, axis, f, late); };
      };
      return S(minimum(in, noise(mtf::Axis::x), noise(mtf::Axis::y)));
    };
    if (!filters_noise(*system_)) return minimum(with(S(1), S(1)), Unfiltered{}, Unfiltered{});
    if (system_->list(mtf::Stage::readout).empty()) return filtered(with(S(1), S(1)), true);
    const S early = filtered(with(S(S(1) - sensor.late), S(S(1) - sensor.late_spatial)), false),
            late = filtered(with(sensor.late, sensor.late_spatial), true);
    return std::isinf(mtf::value_of(early)) ? early : detail::root(S(early * early + late * late));
  }

  const mtf::System<S>* system_;
  MrtdInput<S> input_{};
};

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

/// The eye in front of the display, NVThermIP's form of TTP.
template <class S>
class DisplayObserver {
 public:
  /// `cutoff`: from where on the MTF is 0. Throws UsageError as viewing_of, and for an observer out of range.
  DisplayObserver(const mtf::System<S>& system, const Conditions& conditions, const S& frame_time_s,
                  double cutoff_cy_mrad)
      : observer_(observer_of(system, conditions)),
        cutoff_(cutoff_cy_mrad),
        scene_k_(conditions.scene_contrast_k),
        frame_rate_hz_(conditions.frame_rate_hz ? S(*conditions.frame_rate_hz) : S(S(1) / frame_time_s)),
        spacing_x_mrad_(system.frame.pitch_x_um / system.frame.focal_length_mm),
        spacing_y_mrad_(system.frame.pitch_y_um / system.frame.focal_length_mm),
        x_(channel(system, mtf::Axis::x, false)),
        y_(filters_noise(system) ? channel(system, mtf::Axis::y, false) : x_),
        late_x_(system.list(mtf::Stage::readout).empty() ? x_ : channel(system, mtf::Axis::x, true)),
        late_y_(system.list(mtf::Stage::readout).empty() ? y_ : channel(system, mtf::Axis::y, true)) {
    const S frames = frame_rate_hz_ * S(conditions.eye_time_s);
    kept_ = mtf::value_of(frames) > 1.0 ? frames : S(1);
  }

  /// TTP of a temperature difference at the target, cycles/mrad.
  S ttp_cy_mrad(const SensorAtRange<S>& sensor, const S& contrast_k) const {
    const S temporal2 = sensor.netd_k * sensor.netd_k, spatial2 = kept_ * sensor.spatial_netd_k * sensor.spatial_netd_k,
            all2 = temporal2 + spatial2;
    const S rms_k = detail::root(all2);
    const S late =
        mtf::value_of(all2) > 0.0 ? S((temporal2 * sensor.late + spatial2 * sensor.late_spatial) / all2) : S(0);
    const S density = noise_density(rms_k, spacing_x_mrad_, spacing_y_mrad_, frame_rate_hz_);
    const S contrast = S(0.5) * contrast_k * sensor.contrast_share / scene_k_;
    // Across the bars it is the filters of the other axis that act on the noise.
    const auto along = [&](mtf::Axis axis, const Channel& early, const Channel& behind, const S& across,
                           const S& behind_across) {
      const auto sensitivity = [&](double f) {
        const S seen = (S(1) - late) * early.along(f) * across + late * behind.along(f) * behind_across;
        const S factor = noise_factor(S(kAlphaNvThermIp), density, seen, S(1), scene_k_);
        return system_sensitivity(observer_, f, sensor.otf.mtf(axis, f), factor);
      };
      return axis_ttp(sensitivity_course(sensitivity, cutoff_), sensitivity, contrast);
    };
    return ttp_of(along(mtf::Axis::x, x_, late_x_, y_.across, late_y_.across),
                  along(mtf::Axis::y, y_, late_y_, x_.across, late_x_.across));
  }
  /// ln V, of the cycles on a target of that size at that range; -infinity for none.
  S log_cycles(const SensorAtRange<S>& sensor, const S& contrast_k, const S& size_m, double range_m) const {
    using std::log;
    const S cycles = cycles_on_target(ttp_cy_mrad(sensor, contrast_k), size_m, S(range_m));
    return mtf::value_of(cycles) > 0.0 ? S(log(cycles)) : S(-mtf::kInfinity);
  }
  const Observer<S>& observer() const { return observer_; }

 private:
  /// What the eye's channels let through of the noise along an axis.
  struct Channel {
    S across;
    detail::LogSeries<S> along;
  };
  static Observer<S> observer_of(const mtf::System<S>& system, const Conditions& conditions) {
    const Viewing<S> viewing = viewing_of(conditions, system.frame);
    const Observer<S> observer{.luminance_cd_m2 = S(conditions.luminance_cd_m2),
                               .field_deg = viewing.field_deg,
                               .magnification = viewing.magnification};
    require_valid("observer", observer);
    return observer;
  }
  Channel channel(const mtf::System<S>& system, mtf::Axis axis, bool late) const {
    const auto seen = [&](double f) { return S(noise_mtf(system, axis, f, late) * eye_mtf_at(observer_, S(f))); };
    const double eye_end = 8.0 * mtf::value_of(observer_.magnification);  // the eye's MTF is below 1e-12 there
    const auto along = [&](double f) { return channel_bandwidth<S>(f, seen); };
    const S across = bandwidth<S>(eye_end, seen);
    // Far beyond what eye and display pass there is no noise, down to numbers that have no logarithm.
    constexpr double kNothing = 1e-12;
    double end = std::min(cutoff_, 2.0 * eye_end);
    while (mtf::value_of(along(end)) < kNothing * mtf::value_of(across)) end *= 0.5;
    return {across, detail::LogSeries<S>(end, along)};
  }

  Observer<S> observer_;
  double cutoff_;
  S scene_k_, frame_rate_hz_, spacing_x_mrad_, spacing_y_mrad_, kept_{1};
  Channel x_, y_, late_x_, late_y_;
};

/// How far the MTF of a system counts: to the cutoff of its optics, to four times Nyquist where nothing ends it.
template <class S>
double counted_cy_mrad(const mtf::System<S>& system, double cutoff_cy_mm) {
  const double nyquist =
      0.5e3 / std::sqrt(mtf::value_of(system.frame.pitch_x_um) * mtf::value_of(system.frame.pitch_y_um));
  return mtf::value_of(system.frame.cy_per_mrad(S(cutoff_cy_mm < mtf::kInfinity ? cutoff_cy_mm : 4.0 * nyquist)));
}

}  // namespace radiometry
