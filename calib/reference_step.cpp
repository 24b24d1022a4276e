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

constexpr int kLanes = 8;  // knots that are summed together; every zone is a multiple of them

// One frequency: its weights in E, the line spread and the derivatives, and the rotation by the finest step.
struct Node {
  std::array<double, kSums> weight{};
  double cos = 1.0, sin = 0.0;
};

// Sums over the knots of a zone, `blocks` x kLanes of them. c and s are cos and sin of 2 pi f d at its first knot and
// are moved to its end; (dc, ds) is the rotation of one step.
struct Phase {
  double c = 1.0, s = 0.0, dc = 1.0, ds = 0.0;
};
MTFKIT_CLONES void add_zone(const std::array<double, kSums>& weight, Phase& phase, int blocks, double* __restrict odd,
                            double* __restrict lsf, double* __restrict by_s, double* __restrict by_v,
                            double* __restrict by_q) {
  std::array<double, kLanes> c, s;
  for (std::size_t k = 0; k < kLanes; ++k) {
    c[k] = phase.c;
    s[k] = phase.s;
    const double next = phase.c * phase.dc - phase.s * phase.ds;
    phase.s = phase.s * phase.dc + phase.c * phase.ds;
    phase.c = next;
  }
  // Rotation of a whole block, by three doublings.
  double bc = phase.dc, bs = phase.ds;
  for (int k = 1; k < kLanes; k *= 2) {
    const double next = bc * bc - bs * bs;
    bs = 2.0 * bc * bs;
    bc = next;
  }
  for (int block = 0; block < blocks; ++block) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      odd[k] += weight[0] * s[k];
      lsf[k] += weight[1] * c[k];
      by_s[k] += weight[2] * s[k];
      by_v[k] += weight[3] * s[k];
      by_q[k] += weight[4] * s[k];
      const double next = c[k] * bc - s[k] * bs;
      s[k] = s[k] * bc + c[k] * bs;
      c[k] = next;
    }
    odd += kLanes, lsf += kLanes, by_s += kLanes, by_v += kLanes, by_q += kLanes;
  }
  phase.c = c[0];
  phase.s = s[0];
}

// A Gauss-Legendre rule in t, f = top t (2 - t): smooth at the cutoff, where D ends with the power 3/2.
std::vector<Node> make_nodes(const ReferenceShape& shape, Point normal, double top_cy_px, double reach_px) {
  const double phase = 2.0 * kPi * top_cy_px * reach_px;
  const int wanted = static_cast<int>(0.5 * phase + std::cbrt(phase)) + 10;  // 1e-8
  const int n = std::min((wanted + 7) / 8 * 8, mtf::kMostGaussNodes);
  const mtf::GaussRule& rule = mtf::gauss_legendre(n);
  std::vector<Node> nodes(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double t = 0.5 * (rule.node[i] + 1.0);
    const double f = top_cy_px * t * (2.0 - t);
    const double df = rule.weight[i] * top_cy_px * (1.0 - t);
    const ReferenceOtf h = reference_otf(shape, normal, f);
    Node& node = nodes[i];
    node.weight[0] = df * h.value / (kPi * f);
    node.weight[1] = df * h.value * 2.0;
    for (std::size_t k = 0; k < kShapes; ++k) node.weight[2 + k] = df * h.slope[k] / (kPi * f);
    node.cos = std::cos(2.0 * kPi * f / kFinest);
    node.sin = std::sin(2.0 * kPi * f / kFinest);
  }
  return nodes;
}

}  // namespace

ReferenceOtf reference_otf(const ReferenceShape& shape, double angle_rad, double f_cy_px) {
  return reference_otf(shape, {std::cos(angle_rad), std::sin(angle_rad)}, f_cy_px);
}

ReferenceOtf reference_otf(const ReferenceShape& shape, Point normal, double f_cy_px) {
  const double x = f_cy_px * shape.s_px;
  if (x >= 1.0) return {.value = 0.0};
  const double root = x > 0.0 ? std::sqrt(1.0 - x * x) : 1.0;
  const double pupil = x > 0.0 ? 2.0 / kPi * (std::acos(x) - x * root) : 1.0;
  const double square = 2.0 * kPi * kPi * f_cy_px * f_cy_px;
  const double gauss = std::exp(-square * shape.v_px2);
  const mtf::ValueSlope a = footprint(f_cy_px * normal.x, shape.q_px2);
  const mtf::ValueSlope b = footprint(f_cy_px * normal.y, shape.q_px2);
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
  const double top = s > 0.0 ? std::min(1.0 / s, 1.0 / sigma) : 1.0 / sigma;  // exp(-2 pi^2) = 3e-9
  const double reach = std::min(kReach_px, 10.0 * s + 1.5 * std::sqrt(shape.q_px2) + 5.5 * sigma);
  ReferenceTable table;
  std::size_t summed = 0;
  for (const Node& node : make_nodes(shape, {std::cos(angle_rad), std::sin(angle_rad)}, top, reach)) {
    Phase phase{.c = 1.0, .s = 0.0, .dc = node.cos, .ds = node.sin};
    double start = 0.0, step = 1.0 / kFinest;
    std::size_t first = 0;
    for (const DistanceZone& zone : kDistanceZones) {
      for (; step < zone.step_px; step *= 2.0) {
        const double next = phase.dc * phase.dc - phase.ds * phase.ds;
        phase.ds = 2.0 * phase.dc * phase.ds;
        phase.dc = next;
      }
      const double end = std::min(zone.end_px, reach);
      if (end <= start) break;
      const int blocks = static_cast<int>(std::ceil((end - start) / (step * kLanes)));
      add_zone(node.weight, phase, blocks, &table.odd[first], &table.lsf[first], &table.slope[0][first],
               &table.slope[1][first], &table.slope[2][first]);
      first += static_cast<std::size_t>(blocks * kLanes);
      start = zone.end_px;
    }
    summed = first;
  }
  const double b = 2.0 * kPi * kPi * shape.v_px2 + kPi * kPi * shape.q_px2 / 6.0;
  const double c = (2.0 / 3.0 * s * s * s + 4.0 * s * b) / kPi;
  constexpr double kNear = 2.0 / (kPi * kPi * kPi), kFar = 2.0 / (8.0 * kPi * kPi * kPi * kPi);
  for (std::size_t i = summed; i <= kSideBins; ++i) {
    const double per_d = 1.0 / DistanceBins::get().knot(kSideBins + static_cast<int>(i));
    const double near = kNear * per_d, far = kFar * per_d * per_d * per_d;
    table.odd[i] = 0.5 - near * s - far * c;
    table.lsf[i] = (near * s + 3.0 * far * c) * per_d;
    table.slope[0][i] = -near - far * (2.0 * s * s + 4.0 * b) / kPi;
    table.slope[1][i] = -far * 8.0 * kPi * s;
    table.slope[2][i] = -far * 2.0 * kPi * s / 3.0;
  }
  return table;
}

}  // namespace calib
