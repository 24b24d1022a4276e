// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "mtf/error.h"

namespace calib {
namespace {

constexpr int kEsfSamples = 129;
constexpr double kEsfStep_px = 0.125;  // at the edge
constexpr double kMethodError = 1e-4;  // of curves without noise, see the tolerances of test_measure_truth.cpp

// Distances from -range_px to range_px, kEsfStep_px apart at the edge and wider in the tails: d = a sinh(b t), t in
// [-1, 1].
std::array<double, kEsfSamples> distances(double range_px) {
  constexpr int kHalf = kEsfSamples / 2;
  const double stretch = range_px / (kEsfStep_px * kHalf);  // = sinh(b) / b
  double b = 0.0;
  if (stretch > 1.0) {
    b = std::log(2.0 * stretch) + 1.0;
    for (int round = 0; round < 50; ++round)  // Newton's method from above
      b -= (std::sinh(b) - stretch * b) / (std::cosh(b) - stretch);
  }
  std::array<double, kEsfSamples> d{};
  for (int i = 0; i < kEsfSamples; ++i) {
    const double t = static_cast<double>(i - kHalf) / kHalf;
    d[static_cast<std::size_t>(i)] = range_px * (b > 1e-3 ? std::sinh(b * t) / std::sinh(b) : t);
  }
  return d;
}

void curves_of_frequency(const EdgeResponse& response, EdgeMeasurement& out) {
  for (auto* list : {&out.frequency_cy_px, &out.mtf, &out.mtf_sd, &out.mtf_noise_sd, &out.otf_re, &out.otf_im})
    list->resize(kCurveSamples);
  const std::vector<EdgeResponse::Otf> otfs = response.otfs(kCurveStep_cy_px, kCurveSamples);
  for (std::size_t i = 0; i < kCurveSamples; ++i) {
    const double f = static_cast<double>(i) * kCurveStep_cy_px;
    const EdgeResponse::Otf& otf = otfs[i];
    out.frequency_cy_px[i] = f;
    out.otf_re[i] = otf.re;
    out.otf_im[i] = otf.im;
    out.mtf[i] = otf.mtf();
    out.mtf_sd[i] = f > 0.0 ? std::sqrt(otf.mtf_sd() * otf.mtf_sd() + kMethodError * kMethodError) : 0.0;
    out.mtf_noise_sd[i] = out.mtf_sd[i];
  }
}

void curves_of_distance(const EdgeResponse& response, double range_px, EdgeMeasurement& out) {
  for (auto* list : {&out.distance_px, &out.esf, &out.esf_sd, &out.lsf}) list->resize(kEsfSamples);
  const auto at = distances(range_px);
  for (std::size_t i = 0; i < kEsfSamples; ++i) {
    const double d = at[i];
    out.distance_px[i] = d;
    const EdgeResponse::Step step = response.step(d);
    out.esf[i] = step.esf;
    out.esf_sd[i] = std::sqrt(std::max(0.0, response.variance(step.row)));
    out.lsf[i] = step.lsf;
  }
}

struct CurvePoint {
  double at, value;
};

// Where a function falls to `height`, between a place where it is above and one where it is not: the Illinois variant
// of regula falsi.
template <class Function>
double falls_to(double height, CurvePoint above, CurvePoint below, const Function& function) {
  above.value -= height;
  below.value -= height;
  for (int round = 0; round < 8 && std::abs(below.at - above.at) > 1e-9; ++round) {
    const double at = above.at + (below.at - above.at) * above.value / (above.value - below.value);
    const double value = function(at) - height;
    if (std::abs(value) < 1e-9) return at;
    CurvePoint& moved = value > 0.0 ? above : below;
    (value > 0.0 ? below : above).value *= 0.5;
    moved = {at, value};
  }
  return 0.5 * (above.at + below.at);
}

// Of the MTF less the contrast that is sought, without the error of the method.
struct MtfNoise {
  double variance = 0.0;
  double covariance_with_slope = 0.0;
  double stated = 0.0;  // variance with what another shape of the edge adds, which is no noise and moves no mean
};

// The MTF and its noise from the response itself.
struct MtfOfResponse {
  static constexpr double step_cy_px = 2e-3;  // of derivatives by the frequency
  const EdgeResponse& response;
  std::optional<EdgeResponse::Row> contrast_row{};  // derivatives of a contrast that is itself measured

  double operator()(double f) const { return response.otf(f).mtf(); }
  MtfNoise noise(double f, double step) const {
    EdgeResponse::Row row = response.mtf_row(f);
    const EdgeResponse::Row slope = (response.mtf_row(f + step) - response.mtf_row(f - step)) / (2.0 * step);
    if (contrast_row) row -= *contrast_row;
    const double variance = response.variance(row);
    return {variance, response.covariance(row, slope), variance};
  }
};

// The same from sampled curves, by cubics through four samples. As cov(M, M') is half of the derivative of var(M), the
// samples hold all that is needed.
struct MtfOfCurve {
  const EdgeMeasurement& edge;
  static constexpr double step_cy_px = kCurveStep_cy_px;

  template <class Value>
  double interpolated(double f, const Value& value) const {
    const double x = f / kCurveStep_cy_px;
    const auto i = static_cast<std::size_t>(std::clamp(std::floor(x), 1.0, static_cast<double>(kCurveSamples - 3)));
    const double t = x - static_cast<double>(i);  // Lagrange's polynomial on -1, 0, 1, 2
    return -t * (t - 1.0) * (t - 2.0) / 6.0 * value(i - 1) + (t * t - 1.0) * (t - 2.0) / 2.0 * value(i) -
           t * (t + 1.0) * (t - 2.0) / 2.0 * value(i + 1) + t * (t * t - 1.0) / 6.0 * value(i + 2);
  }
  double operator()(double f) const {
    return interpolated(f, [&](std::size_t i) { return edge.mtf[i]; });
  }
  double variance(double f, const std::vector<double>& sd) const {
    return interpolated(f, [&](std::size_t i) { return std::max(0.0, sd[i] * sd[i] - kMethodError * kMethodError); });
  }
  MtfNoise noise(double f, double step) const {
    const std::vector<double>& sd = edge.mtf_noise_sd.empty() ? edge.mtf_sd : edge.mtf_noise_sd;
    return {std::max(0.0, variance(f, sd)), (variance(f + step, sd) - variance(f - step, sd)) / (4.0 * step),
            std::max(0.0, variance(f, edge.mtf_sd))};
  }
};

// The first frequency, from sample `first` on, at which an MTF falls to a contrast. With M' and M'' the derivatives of
// the MTF by the frequency its noise moves that frequency by dM / -M', so that its sd is sd(M) / -M'. In second order
// the mean of the frequency is off by
//   <df> = cov(M, M') / M'^2 - M'' var(M) / (2 M'^3),
// which is taken off.
template <class Mtf>
std::optional<Estimate> crossing(const Mtf& mtf, const EdgeMeasurement& curves, double contrast, std::size_t first) {
  const std::size_t count = curves.mtf.size();
  while (first < count && !(curves.mtf[first] > contrast)) ++first;
  std::size_t i = first + 1;
  while (i < count && curves.mtf[i] > contrast) ++i;
  if (i >= count) return std::nullopt;
  const double f = falls_to(contrast, {curves.frequency_cy_px[i - 1], curves.mtf[i - 1]},
                            {curves.frequency_cy_px[i], curves.mtf[i]}, mtf);
  const double step = std::min(mtf.step_cy_px, 0.5 * f);
  if (step <= 0.0) return Estimate{f, 0.0};
  const double above = mtf(f + step), below = mtf(f - step);
  const double slope = (above - below) / (2.0 * step), bend = (above - 2.0 * contrast + below) / (step * step);
  if (!(slope < 0.0)) return Estimate{f, 0.0};
  const MtfNoise noise = mtf.noise(f, step);
  const double shift =
      noise.covariance_with_slope / (slope * slope) - bend * noise.variance / (2.0 * slope * slope * slope);
  const double sd = std::hypot(std::sqrt(std::max(0.0, noise.variance)), kMethodError) / -slope;
  return Estimate{f - std::clamp(shift, -0.2 * sd, 0.2 * sd),
                  std::hypot(std::sqrt(std::max(0.0, noise.stated)), kMethodError) / -slope};
}

std::optional<Estimate> frequency_at(const EdgeResponse& response, const EdgeMeasurement& curves, double contrast) {
  return crossing(MtfOfResponse{response}, curves, contrast, 0);
}

// Where the MTF falls to half of its peak, beyond the peak. The noise of the peak is part of the standard deviation;
// that the largest of noisy values is taken for the peak is not corrected.
std::optional<Estimate> frequency_at_half_peak(const EdgeResponse& response, const EdgeMeasurement& curves) {
  const std::vector<double>& mtf = curves.mtf;
  const auto peak = static_cast<std::size_t>(std::max_element(mtf.begin(), mtf.end()) - mtf.begin());
  if (peak == 0) return curves.mtf50;
  double f = curves.frequency_cy_px[peak];
  if (peak + 1 < mtf.size()) {  // the top of the parabola through three samples
    const double bend = mtf[peak - 1] - 2.0 * mtf[peak] + mtf[peak + 1];
    if (bend < 0.0) f += 0.5 * kCurveStep_cy_px * (mtf[peak - 1] - mtf[peak + 1]) / bend;
  }
  return crossing(MtfOfResponse{response, 0.5 * response.mtf_row(f)}, curves, 0.5 * response.otf(f).mtf(), peak);
}

Estimate linear(const EdgeResponse& response, double value, const EdgeResponse::Row& row) {
  return {value, std::sqrt(std::max(0.0, response.variance(row)))};
}

Estimate area_of_mtf(const EdgeResponse& response, const EdgeMeasurement& out) {
  constexpr int kEvery = 4, kNyquist = 100;  // Simpson's rule on samples 0 .. 100, the variance on every fourth
  double sum = 0.0;
  for (int i = 0; i <= kNyquist; ++i)
    sum += (i == 0 || i == kNyquist ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * out.mtf[static_cast<std::size_t>(i)];
  EdgeResponse::Row row = response.mtf_row(0.0) * 0.5;
  for (int i = kEvery; i <= kNyquist; i += kEvery)
    row += response.mtf_row(i * kCurveStep_cy_px) * (i == kNyquist ? 0.5 : 1.0);
  return linear(response, 2.0 * kCurveStep_cy_px / 3.0 * sum, 2.0 * kEvery * kCurveStep_cy_px * row);
}

// Where the line spread falls to half of its largest value on one side of the peak.
double half_height(const EdgeResponse& response, const EdgeMeasurement& out, std::size_t peak, int direction) {
  const double half = 0.5 * out.lsf[peak];
  auto i = static_cast<std::ptrdiff_t>(peak);
  const auto last = static_cast<std::ptrdiff_t>(out.lsf.size()) - 1;
  while (i > 0 && i < last && out.lsf[static_cast<std::size_t>(i)] > half) i += direction;
  const auto sample = [&out](std::ptrdiff_t k) {
    return CurvePoint{out.distance_px[static_cast<std::size_t>(k)], out.lsf[static_cast<std::size_t>(k)]};
  };
  if (sample(i).value > half) return NAN;
  return falls_to(half, sample(i - direction), sample(i), [&](double at) { return response.lsf(at); });
}

std::optional<Estimate> full_width(const EdgeResponse& response, const EdgeMeasurement& out) {
  const auto peak = static_cast<std::size_t>(std::max_element(out.lsf.begin(), out.lsf.end()) - out.lsf.begin());
  if (peak == 0 || peak + 1 == out.lsf.size() || !(out.lsf[peak] > 0.0)) return std::nullopt;
  const double right = half_height(response, out, peak, 1), left = half_height(response, out, peak, -1);
  if (std::isnan(left) || std::isnan(right)) return std::nullopt;
  // The width moves by (half of the peak's change - change there) / slope on either side.
  constexpr double kStep_px = 0.02;
  const EdgeResponse::Row top = 0.5 * response.lsf_row(out.distance_px[peak]);
  const auto side = [&](double at) {
    const double slope = (response.lsf(at + kStep_px) - response.lsf(at - kStep_px)) / (2.0 * kStep_px);
    return EdgeResponse::Row((top - response.lsf_row(at)) / (slope == 0.0 ? 1.0 : slope));
  };
  return linear(response, right - left, side(right) - side(left));
}

// The edge about the place where E is 1/2. It is not the location of least phase where a blur has a tail on one side.
class HalfWay {
 public:
  HalfWay(const EdgeResponse& response, const EdgeMeasurement& out) : response_(response) {
    const auto rises = std::find_if(out.esf.begin() + 1, out.esf.end() - 1, [](double esf) { return esf >= 0.5; });
    const auto i = static_cast<std::size_t>(rises - out.esf.begin());
    at_ = falls_to(0.5, {out.distance_px[i - 1], 1.0 - out.esf[i - 1]}, {out.distance_px[i], 1.0 - out.esf[i]},
                   [&](double d) { return 1.0 - response_.esf(d); });
    moves_ = response_.esf_row(at_) / -std::max(1e-6, response_.lsf(at_));
  }
  double esf(double d_px) const { return response_.esf(at_ + d_px); }
  EdgeResponse::Row row(double d_px) const {
    return response_.esf_row(at_ + d_px) + response_.lsf(at_ + d_px) * moves_;
  }

 private:
  const EdgeResponse& response_;
  double at_ = 0.0;
  EdgeResponse::Row moves_;  // derivatives of the place
};

Estimate overshoot(const EdgeResponse& response, const HalfWay& edge) {
  double at = 1.0, most = edge.esf(at);
  for (double d = 1.0625; d <= 3.0; d += 0.0625)
    if (const double esf = edge.esf(d); esf > most) at = d, most = esf;
  return linear(response, most - 1.0, edge.row(at));
}

double sagitta(const EdgeCurve& curve) {
  constexpr int kSteps = 64;
  const double half = curve.half_length_px;
  if (curve.shape == EdgeCurve::Shape::circle) {
    const double k = curve.curvature_per_px * half;
    return std::abs(k) >= 1.0 ? 1.0 / std::abs(curve.curvature_per_px)
                              : half * std::abs(k) / (1.0 + std::sqrt(1.0 - k * k));
  }
  const auto height = [&](double t) {
    double g = 0.0;
    for (auto k = curve.coefficient.size(); k-- > 0;) g = g * t + curve.coefficient[k];
    return g * t * t;
  };
  double most = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = 2.0 * i / kSteps - 1.0;
    most = std::max(most, std::abs(height(t) - 0.5 * (height(1.0) * (1.0 + t) + height(-1.0) * (1.0 - t))));
  }
  return most;
}

// Changes every standard deviation to combined(deviation, difference from another result, the other's deviation).
template <class Combined>
void combine(const EdgeMeasurement& other, EdgeMeasurement& out, const Combined& combined) {
  for (std::size_t i = 0; i < out.mtf.size(); ++i)
    out.mtf_sd[i] = combined(out.mtf_sd[i], out.mtf[i] - other.mtf[i], other.mtf_sd[i]);
  for (std::size_t i = 0; i < out.esf.size(); ++i) {
    const bool same = i < other.distance_px.size() && other.distance_px[i] == out.distance_px[i];
    if (same) out.esf_sd[i] = combined(out.esf_sd[i], out.esf[i] - other.esf[i], other.esf_sd[i]);
  }
  const auto change = [&](std::optional<Estimate> EdgeMeasurement::*figure, std::optional<double> in_place) {
    std::optional<Estimate>& one = out.*figure;
    if (!one) return;
    const Estimate others = (other.*figure).value_or(Estimate{in_place.value_or(one->value), 0.0});
    one->sd = combined(one->sd, others.value - one->value, others.sd);
  };
  // Where the other MTF does not fall so far, its frequency lies beyond the curves.
  for (auto frequency : {&EdgeMeasurement::mtf10, &EdgeMeasurement::mtf20, &EdgeMeasurement::mtf30,
                         &EdgeMeasurement::mtf50, &EdgeMeasurement::mtf50p})
    change(frequency, 1.0);
  for (auto figure : {&EdgeMeasurement::nyquist, &EdgeMeasurement::rer, &EdgeMeasurement::overshoot,
                      &EdgeMeasurement::fwhm_px, &EdgeMeasurement::mtfa, &EdgeMeasurement::sampling_efficiency})
    change(figure, std::nullopt);
}

}  // namespace

void describe(const EdgeResponse& response, EdgeMeasurement& out) {
  curves_of_frequency(response, out);
  const double width_px = 1.0 / std::max(1e-3, response.lsf(0.0));
  curves_of_distance(response, std::clamp(4.0 * width_px, 8.0, 64.0), out);
  const auto find = [&](double contrast, const char* name, std::optional<Estimate>& place) {
    place = frequency_at(response, out, contrast);
    if (!place)
      out.absent.emplace_back(
          name, "the MTF stays above " + std::to_string(std::lround(100.0 * contrast)) + " % up to 1 cycle per pixel");
  };
  find(0.1, "mtf10", out.mtf10);
  find(0.2, "mtf20", out.mtf20);
  find(0.3, "mtf30", out.mtf30);
  find(0.5, "mtf50", out.mtf50);
  out.mtf50p = frequency_at_half_peak(response, out);
  if (!out.mtf50p) out.absent.emplace_back("mtf50p", "the MTF stays above half of its peak up to 1 cycle per pixel");
  constexpr std::size_t kNyquist = 100;
  out.nyquist = Estimate{out.mtf[kNyquist], out.mtf_sd[kNyquist]};
  const HalfWay edge(response, out);
  out.rer = linear(response, edge.esf(0.5) - edge.esf(-0.5), edge.row(0.5) - edge.row(-0.5));
  out.overshoot = overshoot(response, edge);
  out.fwhm_px = full_width(response, out);
  if (!out.fwhm_px)
    out.absent.emplace_back("fwhm_px", "the line spread function has no peak of half height on both sides");
  out.mtfa = area_of_mtf(response, out);
  if (out.mtf10)
    out.sampling_efficiency = Estimate{2.0 * out.mtf10->value, 2.0 * out.mtf10->sd};
  else
    out.absent.emplace_back("sampling_efficiency", "the MTF stays above 10 % up to 1 cycle per pixel");
}

std::optional<Estimate> frequency_at(const EdgeMeasurement& edge, double contrast) {
  if (!(contrast > 0.0 && std::isfinite(contrast)))
    throw mtf::UsageError("edge: the contrast whose frequency is wanted must be above 0, such as 0.35");
  if (edge.mtf.size() < 2) return std::nullopt;
  if (!edge.mtf_sd.empty()) return crossing(MtfOfCurve{edge}, edge, contrast, 0);
  const auto above = std::find_if(edge.mtf.begin(), edge.mtf.end(), [&](double mtf) { return mtf > contrast; });
  const auto below = std::find_if(above, edge.mtf.end(), [&](double mtf) { return !(mtf > contrast); });
  if (below == edge.mtf.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(below - edge.mtf.begin());
  const double share = (edge.mtf[i - 1] - contrast) / (edge.mtf[i - 1] - edge.mtf[i]);
  return Estimate{std::lerp(edge.frequency_cy_px[i - 1], edge.frequency_cy_px[i], share), NAN};
}

void add_difference(const EdgeMeasurement& other, EdgeMeasurement& out) {
  combine(other, out, [](double sd, double difference, double) { return std::hypot(sd, difference); });
}

void widen_to_end(const EdgeMeasurement& end, EdgeMeasurement& out) {
  constexpr double k95_sd = 1.96;
  combine(end, out, [](double sd, double difference, double others) {
    return std::max({sd, others, std::abs(difference) / k95_sd});
  });
}

void describe_geometry(const EdgeModel& model, const JointFit& joint, const RegionFacts& facts, EdgeMeasurement& out) {
  out.curve = model.curve;
  out.curve.origin.x += facts.middle.x;
  out.curve.origin.y += facts.middle.y;
  out.length_px = 2.0 * model.curve.half_length_px;
  out.sagitta_px = sagitta(model.curve);
  double angle_deg = std::remainder(model.curve.angle_rad * 180.0 / std::numbers::pi, 180.0);
  if (angle_deg <= -90.0) angle_deg += 180.0;
  out.angle_deg.value = angle_deg;
  for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
    if (joint.unknowns[i] != kFirstShift + 1) continue;
    const auto at = static_cast<Eigen::Index>(i);
    out.angle_deg.sd =
        std::sqrt(std::max(0.0, joint.covariance(at, at))) / model.curve.half_length_px * 180.0 / std::numbers::pi;
  }
}

void describe_plateaus(const EdgeModel& model, const NoiseModel& noise, const RegionFacts& facts,
                       EdgeMeasurement& out) {
  out.dark = facts.offset + facts.scale * model.plateau[0];
  out.bright = facts.offset + facts.scale * model.plateau[1];
  out.noise_sd = facts.scale * std::sqrt(noise.at(0.5));
  if (noise.bright != noise.dark)
    out.noise_gain = facts.scale * (noise.bright - noise.dark) / std::max(1e-300, model.contrast());
  out.cnr = (out.bright - out.dark) / out.noise_sd;
}

}  // namespace calib
