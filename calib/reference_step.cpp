// SPDX-License-Identifier: Apache-2.0
#include "calib/reference_step.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mtf/engines/clones.h"
#include "mtf/quadrature.h"
#include "mtf/special.h"

namespace calib {
namespace {

constexpr int kSums = 2 + kShapes;  // E, its slope, its derivatives
constexpr double kPi = mtf::kPi;

// sinc(f sqrt(q) c) and its derivative by q: with x = f c sqrt(q), d sinc / d(x^2) = (cos(pi x) - sinc x) / (2 x^2).
mtf::ValueSlope footprint(double fc, double q_px2) {
  const double x2 = fc * fc * q_px2, a = kPi * kPi * x2;
  if (a < 1e-3) return {1.0 - a / 6.0 * (1.0 - a / 20.0), -fc * fc * kPi * kPi / 6.0 * (1.0 - a / 10.0)};
  const double angle = std::sqrt(a), sinc = std::sin(angle) / angle;
  return {sinc, fc * fc * (std::cos(angle) - sinc) / (2.0 * x2)};
}

struct Nodes {
  std::vector<double> cos, sin, step_cos, step_sin;  // of 2 pi f d and of 2 pi f x step
  std::array<std::vector<double>, kSums> weight;
};

// All sums at the present distance: the even ones (the line spread) take cos, the odd ones sin.
MTFKIT_CLONES void sum_up(const Nodes& nodes, std::array<double, kSums>& sums) {
  const std::size_t n = nodes.cos.size();
  const double *c = nodes.cos.data(), *s = nodes.sin.data();
  const double *w0 = nodes.weight[0].data(), *w1 = nodes.weight[1].data(), *w2 = nodes.weight[2].data(),
               *w3 = nodes.weight[3].data(), *w4 = nodes.weight[4].data();
  std::array<double, 4> a{}, b{}, d{}, e{}, g{};  // n is a multiple of four
  for (std::size_t i = 0; i < n; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      a[k] += w0[i + k] * s[i + k];
      b[k] += w1[i + k] * c[i + k];
      d[k] += w2[i + k] * s[i + k];
      e[k] += w3[i + k] * s[i + k];
      g[k] += w4[i + k] * s[i + k];
    }
  }
  const auto total = [](const std::array<double, 4>& x) { return (x[0] + x[1]) + (x[2] + x[3]); };
  sums = {total(a), total(b), total(d), total(e), total(g)};
}

MTFKIT_CLONES void advance(Nodes& nodes) {
  const std::size_t n = nodes.cos.size();
  double *c = nodes.cos.data(), *s = nodes.sin.data();
  const double *dc = nodes.step_cos.data(), *ds = nodes.step_sin.data();
  for (std::size_t i = 0; i < n; ++i) {
    const double next = c[i] * dc[i] - s[i] * ds[i];
    s[i] = s[i] * dc[i] + c[i] * ds[i];
    c[i] = next;
  }
}

// The rotation of twice the step.
void double_step(Nodes& nodes) {
  for (std::size_t i = 0; i < nodes.cos.size(); ++i) {
    const double c = nodes.step_cos[i], s = nodes.step_sin[i];
    nodes.step_cos[i] = c * c - s * s;
    nodes.step_sin[i] = 2.0 * c * s;
  }
}

// A Gauss-Legendre rule in t, f = top t (2 - t): smooth at the cutoff, where D ends with the power 3/2.
Nodes make_nodes(const ReferenceShape& shape, double angle_rad, double top_cy_px, double reach_px) {
  const double phase = 2.0 * kPi * top_cy_px * reach_px;
  const int wanted = static_cast<int>(0.5 * phase + 2.0 * std::cbrt(phase)) + 14;
  const int n = std::min((wanted + 7) / 8 * 8, mtf::kMostGaussNodes);
  const mtf::GaussRule& rule = mtf::gauss_legendre(n);
  Nodes nodes;
  nodes.cos.assign(static_cast<std::size_t>(n), 1.0);
  nodes.sin.assign(static_cast<std::size_t>(n), 0.0);
  for (auto* list : {&nodes.step_cos, &nodes.step_sin}) list->resize(static_cast<std::size_t>(n));
  for (auto& list : nodes.weight) list.resize(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const double t = 0.5 * (rule.node[i] + 1.0);
    const double f = top_cy_px * t * (2.0 - t);
    const double df = rule.weight[i] * top_cy_px * (1.0 - t);
    const ReferenceOtf h = reference_otf(shape, angle_rad, f);
    nodes.weight[0][i] = df * h.value / (kPi * f);
    nodes.weight[1][i] = df * h.value * 2.0;
    for (std::size_t k = 0; k < kShapes; ++k) nodes.weight[2 + k][i] = df * h.slope[k] / (kPi * f);
    nodes.step_cos[i] = std::cos(2.0 * kPi * f / kFinest);
    nodes.step_sin[i] = std::sin(2.0 * kPi * f / kFinest);
  }
  return nodes;
}

}  // namespace

ReferenceOtf reference_otf(const ReferenceShape& shape, double angle_rad, double f_cy_px) {
  const double x = f_cy_px * shape.s_px;
  if (x >= 1.0) return {.value = 0.0};
  const double root = std::sqrt(1.0 - x * x);
  const double pupil = 2.0 / kPi * (std::acos(x) - x * root);
  const double square = 2.0 * kPi * kPi * f_cy_px * f_cy_px;
  const double gauss = std::exp(-square * shape.v_px2);
  const mtf::ValueSlope a = footprint(f_cy_px * std::cos(angle_rad), shape.q_px2);
  const mtf::ValueSlope b = footprint(f_cy_px * std::sin(angle_rad), shape.q_px2);
  const double value = pupil * gauss * a.value * b.value;
  return {.value = value,
          .slope = {-4.0 / kPi * f_cy_px * root * gauss * a.value * b.value, -square * value,
                    pupil * gauss * (a.slope * b.value + a.value * b.slope)}};
}

// By quadrature as far as the footprint, the Gaussian and the first rings of diffraction reach, by the first two terms
// of the asymptotic series in 1/d from there on: H = 1 - a f + c f^3 in odd powers of f gives
//   E - 1 = -a / (2 pi^2 d) - 2 c / (pi (2 pi d)^3),  a = 4 S / pi,  c = (2 S^3 / 3 + 4 S b) / pi,  H's Gaussian and
// footprint being 1 - b f^2.
ReferenceTable tabulate(const ReferenceShape& shape, double angle_rad) {
  const double s = shape.s_px, sigma = std::sqrt(shape.v_px2);
  const double top = s > 0.0 ? std::min(1.0 / s, 1.15 / sigma) : 1.15 / sigma;  // exp(-2 pi^2 1.15^2) = 5e-12
  const double reach = std::min(kReach_px, 10.0 * s + 1.5 * std::sqrt(shape.q_px2) + 6.5 * sigma);
  Nodes nodes = make_nodes(shape, angle_rad, top, reach);
  ReferenceTable table;
  std::size_t i = 0;
  double d = 0.0, step = 1.0 / kFinest;
  for (const DistanceZone& zone : kDistanceZones) {
    while (step < zone.step_px) {
      double_step(nodes);
      step *= 2.0;
    }
    for (; d < zone.end_px && d <= reach; ++i, d += step) {
      std::array<double, kSums> sums{};
      sum_up(nodes, sums);
      table.odd[i] = sums[0];
      table.lsf[i] = sums[1];
      for (std::size_t k = 0; k < kShapes; ++k) table.slope[k][i] = sums[2 + k];
      advance(nodes);
    }
    if (d > reach) break;
  }
  const double b = 2.0 * kPi * kPi * shape.v_px2 + kPi * kPi * shape.q_px2 / 6.0;
  const double c = (2.0 / 3.0 * s * s * s + 4.0 * s * b) / kPi;
  for (; i <= kSideBins; ++i) {
    d = DistanceBins::get().knot(kSideBins + static_cast<int>(i));
    const double near = 2.0 / (kPi * kPi * kPi * d), far = 2.0 / (kPi * std::pow(2.0 * kPi * d, 3));
    table.odd[i] = 0.5 - near * s - far * c;
    table.lsf[i] = (near * s + 3.0 * far * c) / d;
    table.slope[0][i] = -near - far * (2.0 * s * s + 4.0 * b) / kPi;
    table.slope[1][i] = -far * 8.0 * kPi * s;
    table.slope[2][i] = -far * 2.0 * kPi * s / 3.0;
  }
  return table;
}

}  // namespace calib
