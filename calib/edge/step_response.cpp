// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/step_response.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "mtf/error.h"
#include "mtf/math/clones.h"
#include "mtf/math/quadrature.h"

namespace calib {
namespace {

using mtf::Complex;
using std::numbers::pi;

constexpr std::size_t kLanes = 8;
constexpr std::size_t kMostNodes = 65536;
/// Knots per period of the highest frequency where it matters fully, and the error of the cubics there: (2 pi / 16)^4 /
/// 384 = 6e-5 of the part of E at that frequency, which is the smallest.
constexpr double kKnotsPerPeriod = 16.0;
/// Beyond this distance only tails and the ripple of sharp cutoffs are left, for which wider knots are enough.
constexpr double kNear_px = 8.0;
constexpr double kFarRatio = 6.0;

/// Nodes for f(x) exp(i K x) with f smooth: mtf/math/quadrature.h, rounded up so that few different rules are computed.
int rule_size(double width_cy_px, double range_px) {
  const double turns = pi * width_cy_px * range_px;
  const double n = 0.5 * turns + 2.0 * std::cbrt(turns) + 32.0;
  return 16 * static_cast<int>(std::ceil(std::min(n, 1e6) / 16.0));
}

/// Arrays over the nodes, padded with zeros to whole lanes.
struct Spectrum {
  std::vector<double> sine, sine_slope, cosine, cosine_slope;
};

/// Eight partial sums, so that the order of additions is the same on every machine.
using Lanes [[gnu::vector_size(kLanes * sizeof(double))]] = double;

/// sum a sin and sum b cos over the nodes.
MTFKIT_CLONES void sum_products(std::size_t n, const double* a, const double* sine, const double* b,
                                const double* cosine, double* sums) {
  Lanes odd{}, slope{};
  for (std::size_t i = 0; i < n; i += kLanes) {
    Lanes left, right;
    std::memcpy(&left, a + i, sizeof left);
    std::memcpy(&right, sine + i, sizeof right);
    odd += left * right;
    std::memcpy(&left, b + i, sizeof left);
    std::memcpy(&right, cosine + i, sizeof right);
    slope += left * right;
  }
  sums[0] = sums[1] = 0.0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    sums[0] += odd[lane];
    sums[1] += slope[lane];
  }
}

/// Advances the phases 2 pi f d of all nodes by a step.
MTFKIT_CLONES void turn(std::size_t n, const double* step_cos, const double* step_sin, double* cosine, double* sine) {
  for (std::size_t i = 0; i < n; ++i) {
    const double c = cosine[i] * step_cos[i] - sine[i] * step_sin[i];
    sine[i] = cosine[i] * step_sin[i] + sine[i] * step_cos[i];
    cosine[i] = c;
  }
}

/// cos and sin of 2 pi f d at all nodes.
void phases(const std::vector<double>& f, double d, std::vector<double>& cosine, std::vector<double>& sine) {
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double turns = f[i] * d;
    const double angle = 2.0 * pi * (turns - std::nearbyint(turns));
    cosine[i] = std::cos(angle);
    sine[i] = std::sin(angle);
  }
}

}  // namespace

SliceNodes slice_nodes(double top_cy_px, double range_px, std::span<const double> breaks_cy_px) {
  if (!(top_cy_px > 0.0) || !(range_px > 0.0) || !std::isfinite(top_cy_px * range_px))
    throw mtf::UsageError("slice_nodes: frequencies up to " + std::to_string(top_cy_px) +
                          " cycles/px and distances up to " + std::to_string(range_px) +
                          " px; both have to be above 0");
  std::vector<double> ends{0.0};
  for (const double f : breaks_cy_px)
    if (f > 0.0 && f < top_cy_px) ends.push_back(f);
  ends.push_back(top_cy_px);
  std::sort(ends.begin(), ends.end());

  SliceNodes nodes{.range_px = range_px};
  for (std::size_t piece = 1; piece < ends.size(); ++piece) {
    // Long pieces are cut so that each has a rule of moderate size.
    const double width = ends[piece] - ends[piece - 1];
    if (!(width > 1e-12 * top_cy_px)) continue;
    const double parts = std::ceil(rule_size(width, range_px) / 512.0);
    const int n = rule_size(width / parts, range_px);
    if (static_cast<double>(nodes.f_cy_px.size()) + parts * n > static_cast<double>(kMostNodes))
      throw mtf::UsageError("slice_nodes: an OTF up to " + std::to_string(top_cy_px) + " cycles/px over a region of " +
                            std::to_string(range_px) + " px needs more than " + std::to_string(kMostNodes) +
                            " frequencies; take a smaller region or add the component that limits the frequencies");
    for (double part = 0.0; part < parts; ++part) {
      const double lo = ends[piece - 1] + width * part / parts;
      const mtf::GaussRule rule = mtf::mean_rule(lo, lo + width / parts, n);
      nodes.f_cy_px.insert(nodes.f_cy_px.end(), rule.node.begin(), rule.node.end());
      for (const double weight : rule.weight) nodes.weight.push_back(weight * width / parts);
    }
  }
  return nodes;
}

StepResponse::StepResponse(const SliceNodes& nodes, std::span<const std::vector<Complex<double>>> h)
    : count_(h.size()), range_px_(nodes.range_px) {
  const std::size_t used = nodes.f_cy_px.size();
  const std::size_t n = (used + kLanes - 1) / kLanes * kLanes;
  std::vector<double> f = nodes.f_cy_px;
  f.resize(n, 0.0);
  std::vector<Spectrum> spectra;
  for (const std::vector<Complex<double>>& values : h) {
    assert(values.size() == used);
    Spectrum& s = spectra.emplace_back();
    for (std::vector<double>* array : {&s.sine, &s.sine_slope, &s.cosine, &s.cosine_slope}) array->assign(n, 0.0);
    for (std::size_t i = 0; i < used; ++i) {
      const double w = nodes.weight[i];
      s.sine[i] = w * values[i].re / (pi * f[i]);
      s.sine_slope[i] = 2.0 * w * values[i].re;
      s.cosine[i] = w * values[i].im / (pi * f[i]);
      s.cosine_slope[i] = -2.0 * w * values[i].im;
      symmetric_ = symmetric_ && values[i].im == 0.0;
    }
  }

  const double top = used == 0 ? 1.0 : nodes.f_cy_px.back(), step = 1.0 / (kKnotsPerPeriod * top);
  const double near = std::min(kNear_px, range_px_);
  const auto add_zone = [&](double start, double end, double wanted) {
    const double intervals = std::ceil((end - start) / wanted);
    const std::size_t first = zones_.empty() ? 0 : zones_.back().first + zones_.back().intervals + 1;
    zones_.push_back(
        {start, (end - start) / intervals, intervals / (end - start), first, static_cast<std::size_t>(intervals)});
  };
  add_zone(0.0, near, step);
  if (range_px_ > near) add_zone(near, range_px_, kFarRatio * step);

  const std::size_t width = knot_width();
  knots_.assign((zones_.back().first + zones_.back().intervals + 1) * width, 0.0);
  std::vector<double> cosine(n), sine(n), step_cos(n), step_sin(n);
  for (const Zone& zone : zones_) {
    phases(f, zone.start, cosine, sine);
    phases(f, zone.step, step_cos, step_sin);
    for (std::size_t i = 0; i <= zone.intervals; ++i) {
      double* knot = knots_.data() + (zone.first + i) * width;
      for (const Spectrum& s : spectra) {
        sum_products(n, s.sine.data(), sine.data(), s.sine_slope.data(), cosine.data(), knot);
        knot[1] *= zone.step;
        knot += 2;
        if (symmetric_) continue;
        sum_products(n, s.cosine.data(), cosine.data(), s.cosine_slope.data(), sine.data(), knot);
        knot[1] *= zone.step;
        knot += 2;
      }
      turn(n, step_cos.data(), step_sin.data(), cosine.data(), sine.data());
    }
  }
}

double StepResponse::at(double d_px, std::span<double> values) const {
  assert(values.size() >= count_);
  // NaN counts as a distance beyond the range.
  const double distance = std::abs(d_px) < range_px_ ? std::abs(d_px) : range_px_, sign = d_px < 0.0 ? -1.0 : 1.0;
  const Zone& zone = zones_.size() > 1 && distance >= zones_[1].start ? zones_[1] : zones_[0];
  const double at = (distance - zone.start) * zone.steps_per_px;
  const std::size_t i = std::min(static_cast<std::size_t>(at), zone.intervals - 1);
  const double t = at - static_cast<double>(i), u = 1.0 - t;
  // Cubic Hermite basis in value and slope x step.
  const double left = u * u * (1.0 + 2.0 * t), left_slope = u * u * t, right = t * t * (1.0 + 2.0 * u),
               right_slope = -t * t * u;
  const std::size_t width = knot_width();
  const double* a = knots_.data() + (zone.first + i) * width;
  const double* b = a + width;
  const double* const a0 = a;
  for (std::size_t k = 0; k < count_; ++k) {
    values[k] = sign * (left * a[0] + left_slope * a[1] + right * b[0] + right_slope * b[1]);
    a += 2;
    b += 2;
    if (symmetric_) continue;
    values[k] += left * a[0] + left_slope * a[1] + right * b[0] + right_slope * b[1];
    a += 2;
    b += 2;
  }
  if (count_ == 0) return 0.0;
  values[0] += 0.5;
  if (!(std::abs(d_px) <= range_px_)) return 0.0;
  const double* const b0 = a0 + width;
  const auto slope = [&](std::size_t j) {
    return (6.0 * t * u * (b0[j] - a0[j]) + u * (1.0 - 3.0 * t) * a0[j + 1] + t * (3.0 * t - 2.0) * b0[j + 1]) *
           zone.steps_per_px;
  };
  return slope(0) + (symmetric_ ? 0.0 : sign * slope(2));
}

}  // namespace calib
