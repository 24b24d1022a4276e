// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/made_edges.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "mtf/math/quadrature.h"

namespace made {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kTableSteps = 64;  // a pixel

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x); }

// Autocorrelation of the unit pupil with the phase w020 r^2 + w040 r^4, at `v` of the cutoff: the overlap of two discs
// shifted by +-v, over which the phases differ by 4 x v [w020 + 2 w040 (x^2 + v^2 + y^2)] waves.
double pupil_otf(double v, double w020, double w040) {
  if (v >= 1.0) return 0.0;
  if (w020 == 0.0 && w040 == 0.0) return 2.0 / kPi * (std::acos(v) - v * std::sqrt(1.0 - v * v));
  const mtf::GaussRule& rule = mtf::gauss_legendre(64);
  const double top = std::acos(v);  // y = sin t, so that the lens ends smoothly
  double sum = 0.0;
  for (int j = 0; j < 64; ++j) {
    const double t = 0.5 * top * (rule.node[j] + 1.0), y = std::sin(t), half = std::cos(t) - v;
    double row = 0.0;
    for (int i = 0; i < 64; ++i) {
      const double x = half * rule.node[i];
      row += rule.weight[i] * std::cos(8.0 * kPi * x * v * (w020 + 2.0 * w040 * (x * x + v * v + y * y)));
    }
    sum += rule.weight[j] * 0.5 * top * std::cos(t) * half * row;
  }
  return 2.0 * sum / kPi;
}

}  // namespace

Step::Step(Mtf mtf, double top_cy_px, double range_px)
    : mtf_(std::move(mtf)), range_px_(range_px), top_cy_px_(top_cy_px) {
  const auto points = static_cast<std::size_t>(std::ceil(range_px * kTableSteps)) + 2;
  value_.assign(points, 0.0);
  slope_.assign(points, 0.0);
  const int panels = std::max(8, static_cast<int>(std::ceil(2.0 * top_cy_px * range_px / 16.0)));
  const mtf::GaussRule& rule = mtf::gauss_legendre(64);
  for (int panel = 0; panel < panels; ++panel) {
    for (int k = 0; k < 64; ++k) {
      const double t = (panel + 0.5 * (rule.node[k] + 1.0)) / panels;  // f = top t (2 - t): smooth at the cutoff
      const double f = top_cy_px * t * (2.0 - t);
      const double weight = rule.weight[k] * 0.5 / panels * top_cy_px * 2.0 * (1.0 - t) * mtf_(f);
      const double angle = 2.0 * kPi * f / kTableSteps;
      const double c = std::cos(angle), s = std::sin(angle);
      double re = 1.0, im = 0.0;
      for (std::size_t i = 0; i < points; ++i) {
        value_[i] += weight / (kPi * f) * im;
        slope_[i] += 2.0 * weight * re;
        const double next = re * c - im * s;
        im = im * c + re * s;
        re = next;
      }
    }
  }
}

Step Step::gaussian(double mtf50_cy_px) {
  Step step;
  step.sigma_px_ = std::sqrt(0.5 * std::numbers::ln2) / (kPi * mtf50_cy_px);
  step.mtf_ = [mtf50_cy_px](double f) {
    const double x = f / mtf50_cy_px;
    return std::exp2(-x * x);
  };
  step.top_cy_px_ = 8.0 * mtf50_cy_px;
  return step;
}

Step Step::moved(std::vector<double> places_px) const {
  Step step = *this;
  step.places_px_ = std::move(places_px);
  return step;
}

Step Step::closed(std::function<double(double)> esf, Mtf mtf) {
  Step step;
  step.esf_ = std::move(esf);
  step.mtf_ = std::move(mtf);
  step.top_cy_px_ = 4.0;
  return step;
}

double Step::at(double d_px) const {
  double sum = 0.0;
  for (const double place : places_px_) sum += at_rest(d_px - place);
  return sum / static_cast<double>(places_px_.size());
}

double Step::at_rest(double d_px) const {
  if (esf_) return esf_(d_px);
  if (sigma_px_ > 0.0) return 0.5 * std::erfc(-d_px / (std::numbers::sqrt2 * sigma_px_));
  const double a = std::min(std::abs(d_px), range_px_) * kTableSteps;
  const auto i = static_cast<std::size_t>(a);
  const double t = a - static_cast<double>(i), u = 1.0 - t;
  const double odd = u * u * ((1.0 + 2.0 * t) * value_[i] + t * slope_[i] / kTableSteps) +
                     t * t * ((1.0 + 2.0 * u) * value_[i + 1] - u * slope_[i + 1] / kTableSteps);
  return 0.5 + std::copysign(odd, d_px);
}

double Step::crossing(double contrast) const {
  double low = 0.0, high = 0.0;
  while (high < top_cy_px_ && mtf_(high) >= contrast) low = high, high += 1e-3;
  for (int i = 0; i < 60; ++i) {
    const double mid = 0.5 * (low + high);
    (mtf_(mid) >= contrast ? low : high) = mid;
  }
  return low;
}

Camera camera_of(double f_number) { return {.s = 0.55 * f_number / 4.73}; }

double camera_otf(const Camera& camera, double angle_rad, double f_cy_px) {
  const double fx = f_cy_px * std::cos(angle_rad), fy = f_cy_px * std::sin(angle_rad);
  return pupil_otf(f_cy_px * camera.s, camera.w020, camera.w040) * sinc(fx * camera.pixel) * sinc(fy * camera.pixel) *
         std::cos(2.0 * kPi * camera.olpf * fx) * std::cos(2.0 * kPi * camera.olpf * fy) *
         std::exp(-2.0 * kPi * kPi * camera.variance * f_cy_px * f_cy_px);
}

Step camera_step(const Camera& camera, double angle_deg, double range_px) {
  const double angle_rad = angle_deg * kPi / 180.0;
  double top = camera.s > 0.0 ? 1.0 / camera.s : 64.0;
  if (camera.variance > 0.0) top = std::min(top, 1.4 / std::sqrt(camera.variance));  // exp(-2 pi^2 1.4^2) = 1.6e-17
  return Step([camera, angle_rad](double f) { return camera_otf(camera, angle_rad, f); }, top, range_px);
}

double distance(const Scene& scene, double x, double y) {
  const double a = scene.angle_deg * kPi / 180.0, c = std::cos(a), s = std::sin(a);
  const double px = x - scene.x.value_or(0.5 * static_cast<double>(scene.width));
  const double py = y - scene.y.value_or(0.5 * static_cast<double>(scene.height));
  const double u = c * px + s * py, t = -s * px + c * py;
  const double k = scene.sagitta_px / (scene.half_length_px * scene.half_length_px);
  if (k == 0.0) return u;
  double foot = t;  // nearest point (k foot^2, foot) of the parabola
  for (int i = 0; i < 50; ++i) {
    const double g = (foot - t) + 2.0 * k * foot * (k * foot * foot - u);
    foot -= g / (1.0 + 2.0 * k * (3.0 * k * foot * foot - u));
  }
  return std::copysign(std::hypot(u - k * foot * foot, t - foot), u - k * foot * foot);
}

mtf::Image make(const Step& step, const Scene& scene) {
  mtf::Image image(scene.width, scene.height);
  std::mt19937_64 bits(scene.seed);
  std::normal_distribution<double> normal;
  for (std::int64_t j = 0; j < scene.height; ++j) {
    for (std::int64_t i = 0; i < scene.width; ++i) {
      const double d = distance(scene, static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
      const double e = step.at(d);
      double value = (1.0 - e) * scene.dark + e * scene.bright +
                     std::abs(d) * (d < 0.0 ? scene.gradient_dark : scene.gradient_bright);
      const double variance = scene.noise_sd * scene.noise_sd + scene.noise_gain * std::max(0.0, value);
      if (variance > 0.0) value += std::sqrt(variance) * normal(bits);
      if (scene.quantum > 0.0) value = scene.quantum * std::round(value / scene.quantum);
      image.at(i, j) = static_cast<float>(value);
    }
  }
  return image;
}

}  // namespace made
