// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/radial_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mtf/engines/kernels.h"

namespace mtf {
namespace {

constexpr std::size_t kFirst = 256, kDense = 65536;
constexpr std::size_t kSuspects = 12, kLook = 16;  // intervals that are tested closely, and points in each

// Cubic through four neighbouring samples at t in 0..1 of the middle interval [i, i+1]. Past either end the parabola of
// the last three samples continues: an MTF may have a corner at 0.
double cubic(const std::vector<double>& v, std::size_t i, double t) {
  const std::size_t n = v.size() - 1;
  const double b = v[i], c = v[i + 1];
  const double a = i > 0 ? v[i - 1] : 3.0 * v[0] - 3.0 * v[1] + v[2];
  const double d = i + 2 <= n ? v[i + 2] : 3.0 * v[n] - 3.0 * v[n - 1] + v[n - 2];
  return b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
}

}  // namespace

RadialTable::RadialTable(const Function& f, double end, double target, std::int64_t most) : end_(end) {
  const auto sample = [&](std::size_t count, double first, double step) {
    std::vector<double> r(count), v(count);
    for (std::size_t i = 0; i < count; ++i) r[i] = first + step * static_cast<double>(i);
    f(r, v);
    return v;
  };
  std::size_t n = kFirst;
  std::vector<double> v = sample(n + 1, 0.0, end / static_cast<double>(n));
  for (;;) {
    const double step = end / static_cast<double>(n);
    const std::vector<double> middle = sample(n, 0.5 * step, step);
    double worst = 0.0;
    for (std::size_t i = 0; i < n; ++i) worst = std::max(worst, std::abs(cubic(v, i, 0.5) - middle[i]));
    std::vector<double> merged(2 * n + 1);
    for (std::size_t i = 0; i < n; ++i) merged[2 * i] = v[i], merged[2 * i + 1] = middle[i];
    merged[2 * n] = v[n];
    v = std::move(merged);
    n *= 2;
    // The merged samples are finer by two than the ones just tested: at least 2^1.5 better even at a cutoff's root.
    error_ = worst / 2.8;
    if (error_ <= 0.5 * target || static_cast<std::int64_t>(n) >= most) break;
  }

  double curvature = 0.0;
  for (std::size_t i = 1; i < n; ++i) curvature = std::max(curvature, std::abs(v[i - 1] - 2.0 * v[i] + v[i + 1]));
  // Linear interpolation errs by second difference / 8, which falls with the square of the step.
  std::size_t refine = 1;
  while (refine * n < kDense &&
         curvature / (8.0 * static_cast<double>(refine) * static_cast<double>(refine)) > 0.25 * target)
    refine *= 2;
  knots_.resize(refine * n + 1);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < refine; ++j)
      knots_[i * refine + j][0] = static_cast<float>(cubic(v, i, static_cast<double>(j) / static_cast<double>(refine)));
  knots_[refine * n][0] = static_cast<float>(v[n]);
  for (std::size_t i = 0; i < refine * n; ++i) knots_[i][1] = knots_[i + 1][0] - knots_[i][0];
  error_ = 2.0 * (error_ + curvature / (8.0 * static_cast<double>(refine * refine))) + 1.2e-7;
  between_ = curvature / 8.0;
  for (std::size_t i = 0; i < n; ++i)
    steepest_ = std::max(steepest_, static_cast<double>(n) * (std::abs(v[i + 1] - v[i]) + 0.5 * curvature));

  // A kink (the end of a curve) may lie between the midpoints: more points are tested at the largest third difference.
  std::vector<std::size_t> order(n > 3 ? n - 2 : 0);
  std::iota(order.begin(), order.end(), std::size_t{1});
  const auto third = [&v](std::size_t i) { return std::abs(v[i + 2] - v[i - 1] - 3.0 * (v[i + 1] - v[i])); };
  const auto last = order.begin() + static_cast<std::ptrdiff_t>(std::min(kSuspects, order.size()));
  std::partial_sort(order.begin(), last, order.end(),
                    [&](std::size_t a, std::size_t b) { return third(a) > third(b); });
  for (auto i = order.begin(); i != last; ++i) {
    const double step = 1.0 / static_cast<double>(n * kLook), first = static_cast<double>(*i) / static_cast<double>(n);
    const std::vector<double> exact = sample(kLook, (first + 0.5 * step) * end, step * end);
    for (std::size_t j = 0; j < kLook; ++j) {
      const float r = static_cast<float>(first + (static_cast<double>(j) + 0.5) * step), x2 = r * r;
      float value = 1.0F;
      multiply({&x2, 1}, 0.0F, {&value, 1});
      error_ = std::max(error_, 1.2 * std::abs(static_cast<double>(value) - exact[j]) + 1.2e-7);
    }
  }

  // All of a narrow OTF may lie within the first interval, where a grid of even steps would miss it.
  for (double r = 0.75; r > 0x1p-60; r *= 0.5) {
    const float x2 = static_cast<float>(r * r);
    float value = 1.0F;
    multiply({&x2, 1}, 0.0F, {&value, 1});
    error_ = std::max(error_, 1.2 * std::abs(static_cast<double>(value) - sample(1, r * end, 0.0).front()) + 1.2e-7);
  }

  suffix_max_.resize(n + 1);
  suffix_max_[n] = std::abs(v[n]);
  for (std::size_t i = n; i-- > 0;) suffix_max_[i] = std::max(suffix_max_[i + 1], std::abs(v[i]));
}

void RadialTable::multiply(std::span<const float> x2, float y2, std::span<float> value) const {
  kernels::multiply_by_table(knots_.data(), static_cast<float>(knots_.size() - 1), x2.data(), y2,
                             static_cast<std::int64_t>(value.size()), value.data());
}

void RadialTable::multiply_line(std::span<const float> x, float y, std::span<float> value) const {
  kernels::multiply_by_line_table(knots_.data(), static_cast<float>(knots_.size() - 1), x.data(), y,
                                  static_cast<std::int64_t>(value.size()), value.data());
}

double RadialTable::bound_from(double r) const {
  const double n = static_cast<double>(suffix_max_.size() - 1);
  const double i = std::clamp(std::floor(r / end_ * n), 0.0, n);
  return suffix_max_[static_cast<std::size_t>(i)] + between_ + error_;
}

}  // namespace mtf
