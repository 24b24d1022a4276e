// SPDX-License-Identifier: Apache-2.0
#include "calib/edge/reference_step.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "calib/edge/exponential.h"
#include "mtf/math/clones.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace calib {
namespace {

constexpr std::size_t kSums = 2 + kShapes;  // E, its slope, its derivatives
constexpr std::size_t kLanes = 8;           // knots that are summed together; every zone is a multiple of them
constexpr std::size_t kTogether = 4;        // frequencies that are summed together
constexpr std::size_t kZones = kDistanceZones.size();
constexpr double kPi = mtf::kPi;

// sinc(f sqrt(q) c) and its derivative by q: with x = f |c| sqrt(q), d sinc / d(x^2) = (cos(pi x) - sinc x) / (2 x^2);
// `turn` holds sin(pi x) and cos(pi x).
[[gnu::always_inline]] inline mtf::ValueSlope footprint(double fc, double q_px2, mtf::SinCos turn) {
  constexpr double kSmall = 1e-3;
  const double square = kPi * kPi * fc * fc, a = square * q_px2, large = std::max(a, kSmall);
  const double sinc = turn.sin / std::sqrt(large);
  return {a < kSmall ? 1.0 - a / 6.0 * (1.0 - a / 20.0) : sinc,
          square * (a < kSmall ? a / 60.0 - 1.0 / 6.0 : (turn.cos - sinc) / (2.0 * large))};
}

// D(x) and sqrt(1 - x^2).
struct Pupil {
  double value = 1.0, root = 1.0;
};
Pupil pupil_of(double x) {
  if (x >= 1.0) return {0.0, 0.0};
  if (x <= 0.0) return {};
  const double root = std::sqrt(1.0 - x * x);
  return {2.0 / kPi * (std::acos(x) - x * root), root};
}

[[gnu::always_inline]] inline ReferenceOtf otf_of(const ReferenceShape& shape, Point normal, double f, Pupil pupil,
                                                  mtf::SinCos x, mtf::SinCos y) {
  const double square = 2.0 * kPi * kPi * f * f;
  const double gauss = exponential(std::max(-square * shape.v_px2, -690.0));
  const mtf::ValueSlope a = footprint(f * normal.x, shape.q_px2, x), b = footprint(f * normal.y, shape.q_px2, y);
  const double value = pupil.value * gauss * a.value * b.value;
  return {.value = value,
          .slope = {-4.0 / kPi * f * pupil.root * gauss * a.value * b.value, -square * value,
                    pupil.value * gauss * (a.slope * b.value + a.value * b.slope)}};
}

// sin and cos of 2 pi f x at many frequencies.
struct Turns {
  Turns(std::span<const double> f_cy_px, double x_px) : sin(f_cy_px.size()), cos(f_cy_px.size()) {
    std::vector<double> turns(f_cy_px.size());
    for (std::size_t i = 0; i < turns.size(); ++i) turns[i] = f_cy_px[i] * x_px;
    mtf::sin_cos_turns(turns, sin, cos);
  }
  std::vector<double> sin, cos;
};

// The OTF and its derivatives, a row each.
struct OtfRows {
  explicit OtfRows(std::size_t size) : value(size), by_s(size), by_v(size), by_q(size) {}
  std::vector<double> value, by_s, by_v, by_q;
};

// `value` and `by_s` come as the pupil's value and root.
MTFKIT_CLONES void fill_otf(const ReferenceShape& the_shape, Point normal, std::size_t size,
                            const double* __restrict f_cy_px, const double* __restrict sin_x,
                            const double* __restrict cos_x, const double* __restrict sin_y,
                            const double* __restrict cos_y, double* __restrict value, double* __restrict by_s,
                            double* __restrict by_v, double* __restrict by_q) {
  const ReferenceShape shape = the_shape;
  for (std::size_t i = 0; i < size; ++i) {
    const ReferenceOtf h =
        otf_of(shape, normal, f_cy_px[i], {value[i], by_s[i]}, {sin_x[i], cos_x[i]}, {sin_y[i], cos_y[i]});
    value[i] = h.value;
    by_s[i] = h.slope[0];
    by_v[i] = h.slope[1];
    by_q[i] = h.slope[2];
  }
}

OtfRows otf_rows(const ReferenceShape& shape, Point normal, std::span<const double> f_cy_px) {
  OtfRows rows(f_cy_px.size());
  for (std::size_t i = 0; i < f_cy_px.size(); ++i) {
    const Pupil pupil = pupil_of(f_cy_px[i] * shape.s_px);
    rows.value[i] = pupil.value;
    rows.by_s[i] = pupil.root;
  }
  const double half_px = 0.5 * std::sqrt(shape.q_px2);
  const Turns x(f_cy_px, half_px * std::abs(normal.x)), y(f_cy_px, half_px * std::abs(normal.y));
  fill_otf(shape, normal, f_cy_px.size(), f_cy_px.data(), x.sin.data(), x.cos.data(), y.sin.data(), y.cos.data(),
           rows.value.data(), rows.by_s.data(), rows.by_v.data(), rows.by_q.data());
  return rows;
}

// For each frequency its weights in E, the line spread and the derivatives, and the rotation by the finest step.
struct Nodes {
  std::array<std::vector<double>, kSums> weight;
  Turns turn;
  std::size_t size() const { return weight[0].size(); }
};

// A Gauss-Legendre rule in t, f = top t (2 - t): smooth at the cutoff, where D ends with the power 3/2.
Nodes make_nodes(const ReferenceShape& shape, Point normal, double top_cy_px, double range_px) {
  const double phase = 2.0 * kPi * top_cy_px * range_px;
  const int wanted = static_cast<int>(0.5 * phase + std::cbrt(phase)) + 10;  // 1e-8
  const int n = std::min((wanted + 7) / 8 * 8, mtf::kMostGaussNodes);
  const mtf::GaussRule& rule = mtf::gauss_legendre(n);
  std::vector<double> f_cy_px(static_cast<std::size_t>(n)), df(f_cy_px.size());
  for (std::size_t i = 0; i < f_cy_px.size(); ++i) {
    const double t = 0.5 * (rule.node[i] + 1.0);
    f_cy_px[i] = top_cy_px * t * (2.0 - t);
    df[i] = rule.weight[i] * top_cy_px * (1.0 - t);
  }
  OtfRows otf = otf_rows(shape, normal, f_cy_px);
  std::vector<double> lsf(f_cy_px.size());
  for (std::size_t i = 0; i < f_cy_px.size(); ++i) {
    const double per_f = df[i] / (kPi * f_cy_px[i]);
    lsf[i] = 2.0 * df[i] * otf.value[i];
    otf.value[i] *= per_f;
    otf.by_s[i] *= per_f;
    otf.by_v[i] *= per_f;
    otf.by_q[i] *= per_f;
  }
  return {{std::move(otf.value), std::move(lsf), std::move(otf.by_s), std::move(otf.by_v), std::move(otf.by_q)},
          Turns(f_cy_px, 1.0 / kFinest)};
}

// How many blocks of kLanes knots of each zone are nearer than the range.
std::array<std::size_t, kZones> blocks_within(double range_px) {
  std::array<std::size_t, kZones> blocks{};
  double start = 0.0;
  for (std::size_t z = 0; z < kZones && start < range_px; ++z) {
    const DistanceZone& zone = kDistanceZones[z];
    const double px = std::min(zone.end_px, range_px) - start;
    blocks[z] = static_cast<std::size_t>(std::ceil(px / (zone.step_px * static_cast<double>(kLanes))));
    start = zone.end_px;
  }
  return blocks;
}

using Lanes [[gnu::vector_size(kLanes * sizeof(double))]] = double;

struct Rows {
  double *odd, *lsf, *by_s, *by_v, *by_q;
};

// Adds the frequencies from `first` on, `kTogether` of them. c and s are cos and sin of 2 pi f d at the knots of a
// block.
MTFKIT_CLONES void add_nodes(const Nodes& nodes, std::size_t first, const std::array<std::size_t, kZones>& blocks,
                             Rows rows) {
  // cos and sin of the phase of 0, 1 .. steps of a zone, and of the phase at its first knot.
  std::array<Lanes, kTogether> steps_c, steps_s, c, s;
  std::array<double, kTogether> at_c, at_s, block_c, block_s;
  for (std::size_t j = 0; j < kTogether; ++j) {
    const double dc = nodes.turn.cos[first + j], ds = nodes.turn.sin[first + j];
    double one_c = 1.0, one_s = 0.0;
    for (std::size_t k = 0; k < kLanes; ++k) {
      steps_c[j][k] = one_c;
      steps_s[j][k] = one_s;
      const double next = one_c * dc - one_s * ds;
      one_s = one_s * dc + one_c * ds;
      one_c = next;
    }
    at_c[j] = 1.0;
    at_s[j] = 0.0;
  }
  double step_px = kDistanceZones[0].step_px;
  for (std::size_t z = 0; z < kZones && blocks[z] > 0; ++z) {
    for (; step_px < kDistanceZones[z].step_px; step_px *= 2.0)
      for (std::size_t j = 0; j < kTogether; ++j) {
        const Lanes twice = steps_c[j] * steps_c[j] - steps_s[j] * steps_s[j];
        steps_s[j] = 2.0 * steps_c[j] * steps_s[j];
        steps_c[j] = twice;
      }
    for (std::size_t j = 0; j < kTogether; ++j) {
      c[j] = at_c[j] * steps_c[j] - at_s[j] * steps_s[j];
      s[j] = at_s[j] * steps_c[j] + at_c[j] * steps_s[j];
      const double last_c = steps_c[j][kLanes - 1], last_s = steps_s[j][kLanes - 1];
      block_c[j] = last_c * steps_c[j][1] - last_s * steps_s[j][1];
      block_s[j] = last_s * steps_c[j][1] + last_c * steps_s[j][1];
    }
    for (std::size_t block = 0; block < blocks[z]; ++block) {
      Lanes odd, lsf, by_s, by_v, by_q;
      std::memcpy(&odd, rows.odd, sizeof odd);
      std::memcpy(&lsf, rows.lsf, sizeof lsf);
      std::memcpy(&by_s, rows.by_s, sizeof by_s);
      std::memcpy(&by_v, rows.by_v, sizeof by_v);
      std::memcpy(&by_q, rows.by_q, sizeof by_q);
      for (std::size_t j = 0; j < kTogether; ++j) {
        odd += nodes.weight[0][first + j] * s[j];
        lsf += nodes.weight[1][first + j] * c[j];
        by_s += nodes.weight[2][first + j] * s[j];
        by_v += nodes.weight[3][first + j] * s[j];
        by_q += nodes.weight[4][first + j] * s[j];
        const Lanes next = c[j] * block_c[j] - s[j] * block_s[j];
        s[j] = s[j] * block_c[j] + c[j] * block_s[j];
        c[j] = next;
      }
      std::memcpy(rows.odd, &odd, sizeof odd);
      std::memcpy(rows.lsf, &lsf, sizeof lsf);
      std::memcpy(rows.by_s, &by_s, sizeof by_s);
      std::memcpy(rows.by_v, &by_v, sizeof by_v);
      std::memcpy(rows.by_q, &by_q, sizeof by_q);
      rows = {rows.odd + kLanes, rows.lsf + kLanes, rows.by_s + kLanes, rows.by_v + kLanes, rows.by_q + kLanes};
    }
    for (std::size_t j = 0; j < kTogether; ++j) {
      at_c[j] = c[j][0];
      at_s[j] = s[j][0];
    }
  }
}

// 1 / width of the bins of a side.
constexpr std::array<double, kSideBins> widths_inverse() {
  std::array<double, kSideBins> inverse{};
  std::size_t i = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones)
    for (; from < zone.end_px; from += zone.step_px) inverse[i++] = 1.0 / zone.step_px;
  return inverse;
}

// The cubics through values and slopes at both ends of the bins, about the middle.
MTFKIT_CLONES void fit_cubics(const ReferenceTable& table, BinRow* cubic) {
  static constexpr std::array<double, kSideBins> kPerWidth = widths_inverse();
  for (std::size_t i = 0; i < kSideBins; ++i) {
    const double per_h = kPerWidth[i], h = 1.0 / per_h;
    const double mean = 0.5 * (table.odd[i] + table.odd[i + 1]), rise = (table.odd[i + 1] - table.odd[i]) * per_h;
    const double bend = (table.lsf[i + 1] - table.lsf[i]) * per_h, slope = 0.5 * (table.lsf[i] + table.lsf[i + 1]);
    const double c0 = mean - h * h * bend / 8.0, c1 = 1.5 * rise - 0.5 * slope;
    const double c2 = 0.5 * bend, c3 = 2.0 * per_h * per_h * (slope - rise);
    const std::size_t bright = kSideBins + i, dark = kSideBins - 1 - i;
    cubic[0][bright] = 0.5 + c0;
    cubic[0][dark] = 0.5 - c0;
    cubic[1][bright] = cubic[1][dark] = c1;
    cubic[2][bright] = c2;
    cubic[2][dark] = -c2;
    cubic[3][bright] = cubic[3][dark] = c3;
  }
}

// The weight of the second difference in the value halfway between knots: that of the cubic through four where
// they are evenly spaced, of the straight line elsewhere.
constexpr std::array<double, kSideBins> bulges() {
  std::array<double, kSideBins> bulge{};
  std::size_t i = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones) {
    const auto count = static_cast<std::size_t>((zone.end_px - from) / zone.step_px);
    for (std::size_t k = 0; k < count; ++k) bulge[i + k] = (k > 0 || i == 0) && k + 1 < count ? 0.0625 : 0.0;
    i += count;
    from = zone.end_px;
  }
  return bulge;
}

// An odd function halfway between knots, on both sides.
MTFKIT_CLONES void halfway(const SideKnots& values, BinRow& out) {
  static constexpr std::array<double, kSideBins> kBulge = bulges();
  const auto put = [&](std::size_t i, double before, double after) {
    const double sum = values[i] + values[i + 1], value = 0.5 * sum + kBulge[i] * (sum - before - after);
    out[kSideBins + i] = value;
    out[kSideBins - 1 - i] = -value;
  };
  put(0, -values[1], values[2]);
  for (std::size_t i = 1; i + 1 < kSideBins; ++i) put(i, values[i - 1], values[i + 2]);
  put(kSideBins - 1, values[kSideBins - 2], values[kSideBins]);
}

}  // namespace

constexpr DistanceBins::DistanceBins() {
  constexpr auto kMiddle = static_cast<std::size_t>(kRange_px) * kFinest;
  std::size_t bin = 0;
  double from = 0.0;
  for (const DistanceZone& zone : kDistanceZones)
    for (; from < zone.end_px; from += zone.step_px, ++bin) {
      const double end = from + zone.step_px;
      knot_[kSideBins + bin] = from;
      knot_[kSideBins + bin + 1] = end;
      knot_[kSideBins - bin - 1] = -end;
      centre_[kSideBins + bin] = 0.5 * (from + end);
      centre_[kSideBins - bin - 1] = -0.5 * (from + end);
      for (auto i = static_cast<std::size_t>(from * kFinest); i < static_cast<std::size_t>(end * kFinest); ++i) {
        at_step_[kMiddle + i] = static_cast<std::int16_t>(kSideBins + bin);
        at_step_[kMiddle - 1 - i] = static_cast<std::int16_t>(kSideBins - 1 - bin);
      }
    }
}

const DistanceBins& DistanceBins::get() {
  static constexpr DistanceBins bins;
  return bins;
}

ReferenceOtf reference_otf(const ReferenceShape& shape, Point normal, double f_cy_px) {
  const double width_px = std::sqrt(shape.q_px2);
  const auto turn = [&](double c) { return mtf::sin_cos_pi(f_cy_px * width_px * std::abs(c)); };
  return otf_of(shape, normal, f_cy_px, pupil_of(f_cy_px * shape.s_px), turn(normal.x), turn(normal.y));
}

std::vector<ReferenceOtf> reference_otfs(const ReferenceShape& shape, Point normal, std::span<const double> f_cy_px) {
  const OtfRows rows = otf_rows(shape, normal, f_cy_px);
  std::vector<ReferenceOtf> all(f_cy_px.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = {rows.value[i], {rows.by_s[i], rows.by_v[i], rows.by_q[i]}};
  return all;
}

// A quadrature as far as the footprint, the Gaussian and the first rings of diffraction extend, and the first two terms
// of the asymptotic series in 1/d beyond: H = 1 - a f + c f^3 in odd powers of f gives
//   E - 1 = -a / (2 pi^2 d) - 2 c / (pi (2 pi d)^3),  a = 4 S / pi,  c = (2 S^3 / 3 + 4 S b) / pi,  H's Gaussian and
// footprint being 1 - b f^2.
ReferenceTable tabulate(const ReferenceShape& shape, double angle_rad) {
  const double s = shape.s_px, sigma = std::sqrt(shape.v_px2);
  const double top = s > 0.0 ? std::min(1.0 / s, 1.0 / sigma) : 1.0 / sigma;  // exp(-2 pi^2) = 3e-9
  const double range = std::min(kRange_px, 10.0 * s + 1.5 * std::sqrt(shape.q_px2) + 5.5 * sigma);
  ReferenceTable table;
  const Rows rows{table.odd.data(), table.lsf.data(), table.slope[0].data(), table.slope[1].data(),
                  table.slope[2].data()};
  const std::array<std::size_t, kZones> blocks = blocks_within(range);
  const Nodes nodes = make_nodes(shape, {std::cos(angle_rad), std::sin(angle_rad)}, top, range);
  for (std::size_t first = 0; first < nodes.size(); first += kTogether) add_nodes(nodes, first, blocks, rows);
  const std::size_t summed = kLanes * std::accumulate(blocks.begin(), blocks.end(), std::size_t{0});
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

StepProfile::StepProfile(const ReferenceTable& table) : rows_(kReference + 2) {
  fit_cubics(table, rows_.data());
  for (std::size_t k = 0; k < kShapes; ++k) halfway(table.slope[k], rows_[kCubic + k]);
  rows_[kReference] = esf();
  rows_[kReference + 1] = lsf();
  find_bend_bins();
}

void StepProfile::correct(const BinRow& esf, const BinRow& lsf, const BinRow& c2) {
  for (std::size_t i = 0; i < kBins; ++i) {
    rows_[0][i] += esf[i];
    rows_[1][i] += lsf[i];
    rows_[2][i] += c2[i];
  }
  find_bend_bins();
}

void StepProfile::add_per_s(const BinRow& per_s, double s_px) {
  const DistanceBins& bins = DistanceBins::get();
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t before = i - (i > 0), after = i + (i + 1 < kBins);
    const double apart = bins.centre(static_cast<int>(after)) - bins.centre(static_cast<int>(before));
    rows_[0][i] += s_px * per_s[i];
    rows_[1][i] += s_px * (per_s[after] - per_s[before]) / apart;
    rows_[kCubic][i] += per_s[i];
  }
  rows_[kReference] = esf();
  rows_[kReference + 1] = lsf();
}

void StepProfile::set_reference(const StepProfile& other) {
  std::copy(other.rows_.begin() + kCubic, other.rows_.end(), rows_.begin() + kCubic);
}

void StepProfile::find_bend_bins() {
  const double least = 1e-3 * std::abs(lsf()[kSideBins]);
  const auto seen = [least](double value) { return std::abs(value) > least; };
  const auto first = std::find_if(lsf().begin(), lsf().end(), seen);
  const auto last = std::find_if(lsf().rbegin(), lsf().rend(), seen);
  bend_first = static_cast<int>(first - lsf().begin()) / kLot * kLot;
  bend_end = std::max(bend_first, (static_cast<int>(lsf().rend() - last) + kLot - 1) / kLot * kLot);
}

}  // namespace calib
