// SPDX-License-Identifier: Apache-2.0
#include "calib/iso12233/iso12233_difference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/error.h"

namespace calib {
namespace {

using std::numbers::pi;

double sinc(double x) { return std::abs(x) < 1e-9 ? 1.0 : std::sin(pi * x) / (pi * x); }

/// The region as the standard's method sees it: rows across the edge.
struct Geometry {
  double columns = 0.0, rows = 0.0;
  double cosine = 1.0;  // of the angle between a row and the edge's normal
};

Geometry geometry_of(const Iso12233Result& standard) {
  Geometry region;
  region.columns = static_cast<double>(standard.sfr.size() - 1);
  const bool turned = static_cast<double>(standard.roi.width) != region.columns;
  region.rows = static_cast<double>(turned ? standard.roi.width : standard.roi.height);
  region.cosine = 1.0 / (standard.frequency_cy_px[1] * region.columns);
  return region;
}

/// A curve at the samples of EdgeMeasurement by a cubic through the four nearest. The OTF may have a kink at 0, which
/// no cubic may cross: negative frequencies are mirrored by the caller.
double at_frequency(const std::vector<double>& curve, double f_cy_px) {
  const double x = f_cy_px / kCurveStep_cy_px;
  const auto i = static_cast<std::size_t>(std::clamp(std::floor(x), 1.0, static_cast<double>(kCurveSamples - 3)));
  const double t = x - static_cast<double>(i);
  return -t * (t - 1.0) * (t - 2.0) / 6.0 * curve[i - 1] + (t * t - 1.0) * (t - 2.0) / 2.0 * curve[i] -
         t * (t + 1.0) * (t - 2.0) / 2.0 * curve[i + 1] + t * (t * t - 1.0) / 6.0 * curve[i + 2];
}

/// Modulus of the OTF convolved with the transform of a raised cosine of full width L,
///   W(v) = L [sinc(L v) / 2 + sinc(L v - 1) / 4 + sinc(L v + 1) / 4].
class WindowedOtf {
 public:
  WindowedOtf(const EdgeMeasurement& edge, double width_px) : edge_(edge) {
    constexpr int kLobes = 12, kNodes = 4;  // a lobe
    for (int i = -kLobes * kNodes; i <= kLobes * kNodes; ++i) {
      const double x = static_cast<double>(i) / kNodes;
      shift_.push_back(x / width_px);
      weight_.push_back((0.5 * sinc(x) + 0.25 * sinc(x - 1.0) + 0.25 * sinc(x + 1.0)) / kNodes);
    }
  }
  double operator()(double f) const { return modulus(f) / modulus(0.0); }

 private:
  double modulus(double f) const {
    double re = 0.0, im = 0.0;
    for (std::size_t i = 0; i < shift_.size(); ++i) {
      const double g = f - shift_[i], at = std::min(std::abs(g), 1.0);
      re += weight_[i] * at_frequency(edge_.otf_re, at);
      im += weight_[i] * std::copysign(at_frequency(edge_.otf_im, at), g);
    }
    return std::hypot(re, im);
  }
  const EdgeMeasurement& edge_;
  std::vector<double> shift_, weight_;
};

/// MTF50 and the value at 0.5 cycles per pixel of samples, on straight lines between them.
FigureChange figures_on_lines(const std::vector<double>& frequency_cy_px, const std::vector<double>& curve) {
  FigureChange figures;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const auto between = [&](double share) { return std::lerp(frequency_cy_px[i - 1], frequency_cy_px[i], share); };
    if (!figures.mtf50_cy_px && curve[i] < 0.5)
      figures.mtf50_cy_px = between((curve[i - 1] - 0.5) / (curve[i - 1] - curve[i]));
    if (frequency_cy_px[i - 1] < 0.5 && frequency_cy_px[i] >= 0.5)
      figures.nyquist = std::lerp(curve[i - 1], curve[i],
                                  (0.5 - frequency_cy_px[i - 1]) / (frequency_cy_px[i] - frequency_cy_px[i - 1]));
  }
  return figures;
}

FigureChange less(const FigureChange& a, const FigureChange& b) {
  const auto difference = [](const std::optional<double>& x, const std::optional<double>& y) {
    return x && y ? std::optional(*x - *y) : std::nullopt;
  };
  return {difference(a.mtf50_cy_px, b.mtf50_cy_px), difference(a.nyquist, b.nyquist)};
}

/// One method's step: what it does to a modulus at a frequency.
template <class Step>
std::vector<double> after(std::vector<double> curve, const std::vector<double>& frequency_cy_px, const Step& step) {
  for (std::size_t i = 1; i < curve.size(); ++i) curve[i] = step(frequency_cy_px[i], curve[i]);
  return curve;
}

}  // namespace

Iso12233Difference explain_difference(const EdgeMeasurement& edge, const Iso12233Result& standard) {
  if (edge.trouble != Trouble::none || standard.trouble != Trouble::none || !(edge.roi == standard.roi))
    throw mtf::UsageError("edge: methods are compared where both have measured the same region");
  const Geometry region = geometry_of(standard);
  // Fine samples, on which straight lines are as good as the curve.
  constexpr int kFine = 4000;
  std::vector<double> f, curve;
  for (int i = 0; i <= kFine; ++i) {
    f.push_back(static_cast<double>(i) / kFine);
    curve.push_back(at_frequency(edge.mtf, f.back()));
  }
  const auto figures = [&f](const std::vector<double>& of) { return figures_on_lines(f, of); };

  Iso12233Difference result;
  FigureChange before{edge.mtf50 ? std::optional(edge.mtf50->value) : std::nullopt,
                      edge.nyquist ? std::optional(edge.nyquist->value) : std::nullopt};
  const FigureChange reported{standard.mtf50, standard.nyquist};
  result.total = result.unexplained = less(reported, before);
  before = figures(curve);  // without the correction of the mean of a crossing, which is part of what is unexplained
  const auto add = [&](std::string_view reason, const FigureChange& now) {
    const FigureChange change = less(now, before);
    result.reasons.push_back({reason, change});
    result.unexplained = less(result.unexplained, change);
    before = now;
  };
  const auto apply = [&](std::string_view reason, const auto& step) {
    curve = after(std::move(curve), f, step);
    add(reason, figures(curve));
  };

  apply("averages over bins of a quarter pixel",
        [&](double at, double m) { return m * sinc(0.25 * at * region.cosine); });
  const WindowedOtf windowed(edge, region.columns * region.cosine);
  apply("the window over the region's width", [&](double at, double m) {
    const double whole = std::hypot(at_frequency(edge.otf_re, at), at_frequency(edge.otf_im, at));
    return whole > 0.0 ? m * windowed(at) / whole : m;
  });
  apply("the response of differences, divided out one sample ahead", [&](double at, double m) {
    const double x = 0.5 * pi * at * region.cosine;
    const double y = pi * (at * region.cosine * region.columns + 1.0) / (2.0 * region.columns + 2.0);
    return m * (y / std::sin(y)) / (x / std::sin(x));
  });
  const double power =
      1.5 * pi * pi * region.cosine * region.cosine * region.columns / region.rows / (edge.cnr * edge.cnr);
  apply("noise that is added to the modulus",
        [&](double at, double m) { return std::sqrt(m * m + 0.5 * power * at * at); });
  const double noise_sd = std::sqrt(0.5 * power);  // of the modulus at 1 cycle per pixel
  result.scatter.nyquist = 0.5 * noise_sd;
  if (const auto mtf50 = before.mtf50_cy_px) {
    constexpr int kAside = 20;
    const auto i = static_cast<std::size_t>(std::clamp<long>(std::lround(*mtf50 * kFine), kAside, kFine - kAside));
    const double slope = (curve[i + kAside] - curve[i - kAside]) / (2.0 * kAside / kFine);
    if (slope < 0.0) result.scatter.mtf50_cy_px = *mtf50 * noise_sd / -slope;
  }
  std::vector<double> sampled;
  for (const double at : standard.frequency_cy_px)
    sampled.push_back(curve[static_cast<std::size_t>(std::lround(std::min(1.0, at) * kFine))]);
  add("straight lines between the samples of the curve", figures_on_lines(standard.frequency_cy_px, sampled));

  std::stable_sort(result.reasons.begin(), result.reasons.end(), [](const Iso12233Reason& a, const Iso12233Reason& b) {
    const auto size = [](const FigureChange& change) {
      return std::abs(change.mtf50_cy_px.value_or(change.nyquist.value_or(0.0)));
    };
    return size(a.change) > size(b.change);
  });
  return result;
}

}  // namespace calib
