// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/otf_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "mtf/engines/kernels.h"
#include "mtf/math/barycentric.h"
#include "mtf/math/clones.h"
#include "mtf/math/special.h"
#include "mtf/parallel.h"

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

using Cplx = std::complex<double>;

constexpr std::size_t kFirstSpokes = 16, kMostSpokes = 256;
constexpr std::size_t kFirstPoints = 12, kMostPoints = 96;
constexpr std::size_t kKnots = 512;  // in a piece; the cubic between them errs by less than 1e-9 for a smooth function
constexpr std::size_t kMostProbes = 24, kAllProbes = 96;  // for a piece, for the table; of each kind

// r = begin + (end - begin) (1 - cos(pi t))/2, t in 0..1: the square root of the distance at both ends.
double radius_at(double begin, double end, double t) {
  const double s = std::sin(0.5 * kPi * t);
  return begin + (end - begin) * s * s;
}
double variable_at(double begin, double end, double r) {
  return (2.0 / kPi) * std::asin(std::sqrt(std::clamp((r - begin) / (end - begin), 0.0, 1.0)));
}

// Chebyshev points of a piece: in 0 .. 1.
double variable_of(const Barycentric& points, std::size_t i) { return 0.5 * (1.0 + points.x[i]); }

constexpr std::size_t kLanes = 8;
using Lanes [[gnu::vector_size(kLanes * sizeof(double))]] = double;

/// exp(i m a) = c + i s of the first orders m of a row, and what leads from them to the next ones.
struct Turns {
  std::array<double, kLanes> c, s;
  double turn_c, turn_s;
};
/// Real parts times cosines and imaginary ones times sines, summed over every eighth order.
struct LaneSums {
  std::array<double, kLanes> cosines{}, sines{};
};

/// Of the row that lies between four of `rows`, by their weights.
MTFKIT_CLONES void sum_orders(const double* rows, std::size_t width, bool has_cosines, bool has_sines,
                              const std::array<double, 4>& weight, const Turns& turns, LaneSums& sums) {
  Lanes c, s, cosines{}, sines{};
  std::memcpy(&c, turns.c.data(), sizeof c);
  std::memcpy(&s, turns.s.data(), sizeof s);
  const std::size_t first_sine = has_cosines ? width : 0, row = first_sine + (has_sines ? width : 0);
  for (std::size_t i = 0; i < width; i += kLanes) {
    for (std::size_t k = 0; k < weight.size(); ++k) {
      Lanes one;
      if (has_cosines) {
        std::memcpy(&one, rows + k * row + i, sizeof one);
        cosines += weight[k] * one * c;
      }
      if (has_sines) {
        std::memcpy(&one, rows + k * row + first_sine + i, sizeof one);
        sines += weight[k] * one * s;
      }
    }
    const Lanes next = c * turns.turn_c - s * turns.turn_s;
    s = c * turns.turn_s + s * turns.turn_c;
    c = next;
  }
  std::memcpy(sums.cosines.data(), &cosines, sizeof cosines);
  std::memcpy(sums.sines.data(), &sines, sizeof sines);
}

/// Adds `count` products of complex numbers whose real and imaginary parts stand apart.
MTFKIT_CLONES void add_turned(const double* __restrict a_re, const double* __restrict a_im, const double* __restrict re,
                              const double* __restrict im, std::size_t count, double* __restrict sum_re,
                              double* __restrict sum_im) {
  for (std::size_t i = 0; i < count; ++i) {
    sum_re[i] += a_re[i] * re[i] - a_im[i] * im[i];
    sum_im[i] += a_re[i] * im[i] + a_im[i] * re[i];
  }
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

PolarTable::PolarTable(const Function& h, const Rings& rings, std::vector<double> breaks, double target,
                       std::int64_t most, int threads) {
  double begin = 0.0;
  for (const double end : breaks) {
    if (end > begin * (1.0 + 1e-9)) pieces_.push_back({begin, end, {}}), begin = end;
  }
  std::size_t spokes = kFirstSpokes, points = kFirstPoints;
  for (;;) {
    const std::int64_t before = evaluations_;
    tabulate(rings, spokes, points);
    const std::int64_t last = evaluations_ - before;
    const double around = probe(h, spokes, points, true, threads), outwards = probe(h, spokes, points, false, threads);
    error_ = 2.0 * (around + outwards);
    const bool more_spokes =
        around > 0.25 * target && spokes<kMostSpokes, more_points = outwards> 0.25 * target && points < kMostPoints;
    if (more_spokes) spokes *= 2;
    if (more_points) points *= 2;
    const auto next =
        last * (more_spokes ? 2 : 1) * (more_points ? 2 : 1) + static_cast<std::int64_t>(2 * probes() * pieces_.size());
    if ((!more_spokes && !more_points) || evaluations_ + next > most) return;
  }
}

PolarTable::Rings PolarTable::rings_of(Function h, int threads, bool radial) {
  if (radial)
    return [h = std::move(h), threads](std::span<const double> r, std::size_t spokes, std::span<Cplx> rows) {
      std::ranges::fill(rows, Cplx{});
      parallel_for(std::ssize(r), 8, threads, [&](std::int64_t first, std::int64_t last) {
        for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i)
          rows[i * (spokes / 2)] = h({r[i], 0.0}).re;
      });
      return std::ssize(r);
    };
  // H(r, a + pi) = conj H(r, a): half of the spokes. With H = A + i B the series of A has even orders, that of B odd
  // ones: c_m exp(i m a) below is the part of A (m even) or of B (m odd) whose real part counts.
  return [h = std::move(h), threads](std::span<const double> r, std::size_t spokes, std::span<Cplx> rows) {
    const std::size_t half = spokes / 2;
    std::vector<Cplx> turn(spokes), value(r.size() * half);
    for (std::size_t k = 0; k < spokes; ++k) {
      const double a = 2.0 * static_cast<double>(k) / static_cast<double>(spokes);
      turn[k] = {cos_pi(a), sin_pi(a)};
    }
    parallel_for(static_cast<std::int64_t>(value.size()), 8, threads, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t k = first; k < last; ++k) {
        const auto i = static_cast<std::size_t>(k) / half, j = static_cast<std::size_t>(k) % half;
        const Complex<double> z = h({r[i] * turn[j].real(), r[i] * turn[j].imag()});
        value[static_cast<std::size_t>(k)] = {z.re, z.im};
      }
    });
    for (std::size_t i = 0; i < r.size(); ++i)
      for (std::size_t m = 0; m < half; ++m) {
        Cplx sum{};
        for (std::size_t j = 0; j < half; ++j) {
          const double part = m % 2 == 0 ? value[i * half + j].real() : value[i * half + j].imag();
          sum += part * std::conj(turn[j * m % spokes]);
        }
        rows[i * half + m] = (m == 0 ? 1.0 : 2.0) / static_cast<double>(half) * sum;
      }
    return static_cast<std::int64_t>(value.size());
  };
}

void PolarTable::set_orders(std::size_t orders) {
  orders_ = orders;
  width_ = (orders + kLanes - 1) / kLanes * kLanes;
}

void PolarTable::tabulate(const Rings& rings, std::size_t spokes, std::size_t points) {
  set_orders(spokes / 2);
  const Barycentric at = Barycentric::inside(points);
  std::vector<double> weight(points);
  for (Piece& piece : pieces_) {
    std::vector<double> r(points);
    for (std::size_t i = 0; i < points; ++i) r[i] = radius_at(piece.begin, piece.end, variable_of(at, i));
    std::vector<Cplx> series(points * orders_);
    evaluations_ += rings(r, spokes, series);
    piece.rows.assign((kKnots + 3) * row_size(), 0.0);
    for (std::size_t k = 0; k < kKnots + 3; ++k) {
      double* const row = piece.rows.data() + k * row_size();
      const double t = (static_cast<double>(k) - 1.0) / static_cast<double>(kKnots);
      at.weights_at(2.0 * t - 1.0, weight.data());
      for (std::size_t i = 0; i < points; ++i)
        for (std::size_t m = 0; m < orders_; ++m) {
          row[m] += weight[i] * series[i * orders_ + m].real();
          row[width_ + m] += weight[i] * series[i * orders_ + m].imag();
        }
    }
  }
}

PolarTable PolarTable::combination(std::span<const PolarTable* const> tables,
                                   std::span<const std::vector<Cplx>> weight) {
  PolarTable sum;
  std::size_t orders = 0;
  for (const PolarTable* table : tables) orders = std::max(orders, table->orders_);
  sum.set_orders(orders);
  for (const Piece& piece : tables.front()->pieces_)
    sum.pieces_.push_back({piece.begin, piece.end, std::vector<double>((kKnots + 3) * sum.row_size())});
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const PolarTable& table = *tables[i];
    if (std::all_of(weight[i].begin(), weight[i].end(), [](const Cplx& w) { return w == 0.0; })) continue;
    std::vector<double> re, im;
    for (const Cplx& w : weight[i]) re.push_back(w.real()), im.push_back(w.imag());
    for (std::size_t p = 0; p < sum.pieces_.size(); ++p)
      for (std::size_t k = 0; k < kKnots + 3; ++k) {
        double* const to = sum.pieces_[p].rows.data() + k * sum.row_size();
        const double* const from = table.pieces_[p].rows.data() + k * table.row_size();
        add_turned(re.data(), im.data(), from, from + table.width_, table.orders_, to, to + sum.width_);
      }
  }
  return sum;
}

// cos(m a) is even along y, and along x where m is even; sin(m a) is odd along y, and along x where m is even.
PolarTable PolarTable::parts(const Parities& wanted) const {
  const auto has = [&](Parity x, Parity y) { return wanted.has({x, y}) ? 1.0 : 0.0; };
  const std::array<double, 2> cosines{has(Parity::even, Parity::even), has(Parity::odd, Parity::even)},
      sines{has(Parity::odd, Parity::odd), has(Parity::even, Parity::odd)};
  PolarTable result;
  for (const std::size_t m : {0U, 1U})
    if (cosines[m] == 0.0 && sines[m] == 0.0) result.first_ = 1 - m, result.step_ = 2;
  result.cosines_ = cosines[0] != 0.0 || cosines[1] != 0.0;
  result.sines_ = sines[0] != 0.0 || sines[1] != 0.0;
  result.set_orders((orders_ - result.first_ + result.step_ - 1) / result.step_);
  for (const Piece& piece : pieces_) {
    std::vector<double>& rows = result.pieces_.emplace_back(Piece{piece.begin, piece.end, {}}).rows;
    rows.assign((kKnots + 3) * result.row_size(), 0.0);
    for (std::size_t k = 0; k < kKnots + 3; ++k) {
      const double* const from = piece.rows.data() + k * row_size();
      double* const to = rows.data() + k * result.row_size();
      double* const sine = to + (result.cosines_ ? result.width_ : 0);
      for (std::size_t m = result.first_, i = 0; m < orders_; m += result.step_, ++i) {
        if (result.cosines_) to[i] = cosines[m % 2] * from[m];
        if (result.sines_) sine[i] = sines[m % 2] * from[width_ + m];
      }
    }
  }
  return result;
}

std::array<double, 4> PolarTable::parts_at(const Freq<double>& f) const {
  const double r = std::sqrt(f.x * f.x + f.y * f.y);
  const auto piece = std::find_if(pieces_.begin(), pieces_.end(), [r](const Piece& p) { return r < p.end; });
  if (piece == pieces_.end()) return {};
  const double position = static_cast<double>(kKnots) * variable_at(piece->begin, piece->end, r);
  const std::size_t knot = std::min(static_cast<std::size_t>(position), kKnots - 1);
  const double t = position - static_cast<double>(knot);
  // Lagrange's cubic through the knots at -1, 0, 1, 2.
  const std::array<double, 4> weight{-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
                                     -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0};
  // Powers of the direction, each half from the one before.
  const Cplx one = r > 0.0 ? Cplx{f.x / r, f.y / r} : Cplx{1.0, 0.0};
  const auto times = [](const Cplx& a, const Cplx& b) {  // operator* looks for infinities
    return Cplx{a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  };
  Cplx turn = step_ == 1 ? one : times(one, one);
  std::array<Cplx, kLanes> power{first_ == 0 ? Cplx{1.0, 0.0} : one};
  for (std::size_t half = 1; half < kLanes; half *= 2, turn = times(turn, turn))
    for (std::size_t i = 0; i < half; ++i) power[half + i] = times(power[i], turn);
  Turns turns{.c = {}, .s = {}, .turn_c = turn.real(), .turn_s = turn.imag()};
  for (std::size_t i = 0; i < kLanes; ++i) turns.c[i] = power[i].real(), turns.s[i] = power[i].imag();
  LaneSums sums;
  sum_orders(piece->rows.data() + knot * row_size(), width_, cosines_, sines_, weight, turns, sums);
  std::array<double, 2> cosines{}, sines{};  // of every other order
  for (std::size_t i = 0; i < kLanes; ++i) cosines[i % 2] += sums.cosines[i], sines[i % 2] -= sums.sines[i];
  if (step_ == 1) return {cosines[0], sines[1], cosines[1], sines[0]};
  if (first_ == 0) return {cosines[0] + cosines[1], 0.0, 0.0, sines[0] + sines[1]};
  return {0.0, sines[0] + sines[1], cosines[0] + cosines[1], 0.0};
}

Complex<double> PolarTable::at(const Freq<double>& f) const {
  const auto [ee, eo, oe, oo] = parts_at(f);
  return {ee + oo, eo + oe};
}

std::int64_t PolarTable::bytes() const {
  return static_cast<std::int64_t>(pieces_.size() * (kKnots + 3) * row_size() * sizeof(double));
}

std::size_t PolarTable::probes() const { return std::clamp(kAllProbes / pieces_.size(), std::size_t{8}, kMostProbes); }

// The largest error between the spokes, or between the points; there the series and the polynomial are worst.
double PolarTable::probe(const Function& h, std::size_t spokes, std::size_t points, bool around, int threads) {
  const std::size_t count = probes();
  const Barycentric at_points = Barycentric::inside(points);
  std::vector<double> error(pieces_.size() * count);
  parallel_for(static_cast<std::int64_t>(error.size()), 4, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      const Piece& piece = pieces_[static_cast<std::size_t>(k) / count];
      const std::size_t n = static_cast<std::size_t>(k) % count;
      // Spread over the piece and all directions, away from the points of the table.
      const double spread = std::fmod(static_cast<double>(n) * 0.6180339887498949, 1.0);
      const std::size_t i = n * points / count;
      const auto j = static_cast<double>(static_cast<std::size_t>(spread * static_cast<double>(spokes)));
      const double on = variable_of(at_points, i), next = i + 1 < points ? variable_of(at_points, i + 1) : 1.0;
      const double t = around ? on : 0.5 * (on + next);
      const double a = 2.0 * (around ? j + 0.5 : j) / static_cast<double>(spokes);
      const double r = radius_at(piece.begin, piece.end, t);
      const Freq<double> f{r * cos_pi(a), r * sin_pi(a)};
      const Complex<double> exact = h(f), table = at(f);
      error[static_cast<std::size_t>(k)] = std::hypot(exact.re - table.re, exact.im - table.im);
    }
  });
  evaluations_ += static_cast<std::int64_t>(error.size());
  return *std::max_element(error.begin(), error.end());
}

void PolarTable::multiply(std::span<const double> fx, double fy, std::span<Complex<double>> h) const {
  for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * at({fx[i], fy});
}

}  // namespace mtf
