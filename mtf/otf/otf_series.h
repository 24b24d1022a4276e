// SPDX-License-Identifier: Apache-2.0
#pragma once

// An OTF along a direction as Chebyshev series, from few evaluations: everything else that is wanted of it is cheap.
// On a panel f = lo + (hi - lo) sin^2(pi s / 2), 0 <= s <= 1, so that half powers of the distance to either end, as an
// aperture's OTF has them at its cutoff and turbulence at 0, are smooth in s; t = 2 s - 1 = cos(pi k / n), k = 0 .. n,
// are the points of the series of degree n. Doubling n keeps the points there are; a panel that 64 do not resolve is
// halved, or parted at a kink where one is known in it. The error of a series is taken from its last coefficients, from
// how far they have fallen. (Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, ch. 3, 4 and 8.)

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace mtf {

inline constexpr int kLeastDegree = 16, kMostDegree = 64;  ///< degrees of a series

/// Tables for a degree, made once: the share of the panel below each point, and what turns values into coefficients.
struct ChebyshevPoints {
  std::vector<double> share;
  std::vector<double> transform;  ///< [point][coefficient]
};
const ChebyshevPoints& chebyshev_points(int degree);
/// The tables of a degree, for any degree.
std::vector<double> chebyshev_transform(int degree);

/// Gauss-Legendre nodes on a panel for a series of that degree, made once: what each basis function is there.
struct FineNodes {
  std::vector<double> t, share, weight;  ///< rising; share and weight as parts of the panel's width
  std::vector<double> basis;             ///< [k][node] = T_k(t)
};
/// It has as many nodes as the product of the series and a wave of `cycles` over the panel needs, or the most there
/// are.
const FineNodes& fine_nodes(int degree, double cycles);
/// Whether they are as many as the product needs.
bool nodes_suffice(int degree, double cycles);

/// result[i] = sum over k of matrix[k][i] x factor[k]; for double on whatever vectors the machine has.
void add_products(const double* matrix, std::span<const double> factor, std::span<double> result);
template <class S>
void add_products(const double* matrix, const std::vector<S>& factor, std::vector<S>& result) {
  if constexpr (std::is_same_v<S, double>) {
    add_products(matrix, std::span<const double>(factor), std::span<double>(result));
  } else {
    std::fill(result.begin(), result.end(), S(0));
    for (const S& f : factor) {
      for (std::size_t i = 0; i < result.size(); ++i) result[i] += S(matrix[i]) * f;
      matrix += result.size();
    }
  }
}

/// The series at many places, by Clenshaw's recurrence.
void chebyshev_sums(std::span<const double> coefficient, std::span<const double> t, std::span<double> value);

/// Values at the points become coefficients in place: value = sum of c_k T_k(t).
template <class S>
void chebyshev_coefficients(std::vector<S>& value) {
  std::vector<S> coefficient(value.size());
  add_products(chebyshev_points(static_cast<int>(value.size()) - 1).transform.data(), value, coefficient);
  value = std::move(coefficient);
}

/// Clenshaw's recurrence.
template <class S>
S chebyshev(const std::vector<S>& coefficient, double t) {
  S b1{}, b2{};
  for (std::size_t k = coefficient.size(); k-- > 1;) {
    const S b = S(2.0 * t) * b1 + (coefficient[k] - b2);
    b2 = b1;
    b1 = b;
  }
  return S(t) * b1 + (coefficient[0] - b2);
}

/// The same at many places at once.
template <class S>
std::vector<S> chebyshev_at(const std::vector<S>& coefficient, std::span<const double> t) {
  if constexpr (std::is_same_v<S, double>) {
    std::vector<double> value(t.size());
    chebyshev_sums(coefficient, t, value);
    return value;
  } else {
    std::vector<S> b1(t.size()), b2(t.size()), b(t.size());
    for (std::size_t k = coefficient.size(); k-- > 1;) {
      const S c = coefficient[k];
      for (std::size_t i = 0; i < t.size(); ++i) b[i] = S(2.0 * t[i]) * b1[i] + (c - b2[i]);
      b2.swap(b1);
      b1.swap(b);
    }
    for (std::size_t i = 0; i < t.size(); ++i) b[i] = S(t[i]) * b1[i] + (coefficient[0] - b2[i]);
    return b;
  }
}

/// The size of the coefficients beyond the last, from the sums of the last two quarters: exact for those that fall
/// by the same factor from each to the next, three times that since a kink's fall ever slower (as k^-2.5 for one of
/// power 3/2, of which the exact part is 0.39; a power of 1/2, k^-1.5, is bounded through the limit of the factor).
/// Tests hold errors against it.
template <class S>
double series_tail(const std::vector<S>& coefficient) {
  const std::size_t end = coefficient.size(), quarter = end / 4;
  const auto sum = [&](std::size_t from) {
    double all = 0.0;
    for (std::size_t k = from; k < from + quarter; ++k) all += std::abs(value_of(coefficient[k]));
    return all;
  };
  const double last = sum(end - quarter), before = sum(end - 2 * quarter);
  constexpr double kSlowest = 0.75, kSafety = 3.0;
  const double factor = before > 0.0 ? std::min(last / before, kSlowest) : kSlowest;
  return kSafety * last * factor / (1.0 - factor);
}

/// Place and slope of a panel's frequencies.
struct PanelPlace {
  double f = 0.0, slope = 0.0;  ///< df/dt
};

/// The same for many.
struct PanelPlaces {
  std::vector<double> f, slope;
};

struct PanelMap {
  double lo = 0.0, hi = 0.0;
  PanelPlaces at(std::span<const double> t) const;
  PanelPlace at(double t) const {
    const auto [s, c] = sin_cos_pi(0.25 * (1.0 + t));
    return {lo + (hi - lo) * s * s, 0.5 * kPi * (hi - lo) * s * c};
  }
  double f(double t) const { return at(t).f; }
  double slope(double t) const { return at(t).slope; }
  double t(double f) const {
    const double share = std::clamp((f - lo) / (hi - lo), 0.0, 1.0);
    return 4.0 / kPi * std::atan2(std::sqrt(share), std::sqrt(1.0 - share)) - 1.0;
  }
};

/// Real and imaginary part; the latter is empty where it is 0 throughout.
template <class S>
struct ComplexSeries {
  std::vector<S> re, im;
  Complex<S> at(double t) const { return {chebyshev(re, t), im.empty() ? S(0) : chebyshev(im, t)}; }
};

template <class S>
ComplexSeries<S> make_series(const std::vector<Complex<S>>& value) {
  ComplexSeries<S> series;
  series.re.reserve(value.size());
  for (const Complex<S>& h : value) series.re.push_back(h.re);
  if (std::any_of(value.begin(), value.end(), [](const Complex<S>& h) { return value_of(h.im) != 0.0; })) {
    series.im.reserve(value.size());
    for (const Complex<S>& h : value) series.im.push_back(h.im);
    chebyshev_coefficients(series.im);
  }
  chebyshev_coefficients(series.re);
  return series;
}

template <class S>
double tail(const ComplexSeries<S>& series) {
  return series_tail(series.re) + (series.im.empty() ? 0.0 : series_tail(series.im));
}

/// An OTF along an axis, from its series.
template <class S>
class OtfCurve {
 public:
  void clear() { parts_.clear(); }
  /// Panels are added in the order of rising frequencies.
  void add(const PanelMap& map, const ComplexSeries<S>& series) { parts_.push_back({map, series}); }
  bool empty() const { return parts_.empty(); }
  /// Adds weight x another OTF to an empty curve or to one of the same panels; false, and nothing done, for others.
  bool add(const OtfCurve& other, double weight) {
    if (empty()) parts_.resize(other.parts_.size());
    const auto same = [](const Part& a, const Part& b) {
      return a.map.hi == 0.0 || (a.map.lo == b.map.lo && a.map.hi == b.map.hi);
    };
    if (!std::equal(parts_.begin(), parts_.end(), other.parts_.begin(), other.parts_.end(), same)) return false;
    const auto add_series = [weight](std::vector<S>& sum, const std::vector<S>& series) {
      sum.resize(std::max(sum.size(), series.size()), S(0));
      for (std::size_t k = 0; k < series.size(); ++k) sum[k] += S(weight) * series[k];
    };
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      parts_[p].map = other.parts_[p].map;
      add_series(parts_[p].series.re, other.parts_[p].series.re);
      add_series(parts_[p].series.im, other.parts_[p].series.im);
    }
    return true;
  }

  /// The modulus at |f|, with the derivatives of f as well; 0 beyond the last panel.
  S modulus(const S& f_cy_mm) const {
    using std::sqrt;
    const Complex<S> h = at(f_cy_mm);
    const S square = h.re * h.re + h.im * h.im;
    return value_of(square) > 0.0 ? S(sqrt(square)) : S(0);
  }
  /// The real part about the centroid of the point spread, where a shift has no part in it: below 0 where detail has
  /// the wrong contrast. With the derivatives of f; 0 beyond the last panel.
  S centred(const S& f_cy_mm) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    const Complex<S> h = at(f_cy_mm);
    if (value_of(h.im) == 0.0) return h.re;
    constexpr double kNearZero = 1e-4;  // of the first panel: shifts of 1000 px turn the phase there by less than pi
    const S near(kNearZero * parts_.front().map.hi);
    const Complex<S> low = at(near);
    const S turn = atan2(low.im, low.re) * f_cy_mm / near;
    return h.re * cos(turn) + h.im * sin(turn);
  }
  /// Where the OTF first passes through 0 and changes its sign; infinite where it does not.
  double reversal_cy_mm() const {
    constexpr double kZero = 1e-3;  // a phase that turns by half a wave at some contrast is no reversal of it
    double before = 0.0;
    for (const Part& part : parts_) {
      const auto value = [&](double f) { return value_of(centred(S(f))); };
      const int steps = static_cast<int>(part.series.re.size());
      for (int i = 1; i <= steps; ++i) {
        double lo = before, hi = i == steps ? part.map.hi : part.map.f(2.0 * i / steps - 1.0);
        before = hi;
        if (!(value(hi) < 0.0) || value(lo) < 0.0) continue;
        while (true) {
          const double middle = 0.5 * (lo + hi);
          if (!(middle > lo && middle < hi)) break;
          (value(middle) < 0.0 ? hi : lo) = middle;
        }
        if (value_of(modulus(S(hi))) < kZero) return hi;
      }
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  struct Part {
    PanelMap map;
    ComplexSeries<S> series;
  };
  Complex<S> at(const S& f_cy_mm) const {
    const double f = std::abs(value_of(f_cy_mm));
    const auto part = std::find_if(parts_.begin(), parts_.end(), [f](const Part& p) { return f <= p.map.hi; });
    if (part == parts_.end()) return {};
    const double t = part->map.t(f);
    Complex<S> h = part->series.at(t);
    if constexpr (requires { f_cy_mm.a; }) {
      const double slope = part->map.slope(t);
      if (!(slope > 0.0)) return h;  // the ends of a panel, where t turns
      constexpr double d = 1e-3;     // the formula is of fourth order, and a series is smooth on the scale of 1
      const S step = (f_cy_mm - S(value_of(f_cy_mm))) / S(slope);
      const auto moved = [&](const std::vector<S>& series) {
        const auto value = [&](double at) { return value_of(chebyshev(series, at)); };
        return S((8.0 * (value(t + d) - value(t - d)) - (value(t + 2 * d) - value(t - 2 * d))) / (12.0 * d)) * step;
      };
      h.re += moved(part->series.re);
      if (!part->series.im.empty()) h.im += moved(part->series.im);
    }
    return h;
  }
  std::vector<Part> parts_;
};

/// N OTFs on one panel.
template <class S, std::size_t N>
struct SeriesPanel {
  PanelMap map;
  std::array<ComplexSeries<S>, N> otf;
  int degree = 0;
  double error = 0.0;  ///< that of the worst OTF, relative to its largest value where that is above 1
};

template <class S, std::size_t N>
using SeriesValues = std::array<std::vector<Complex<S>>, N>;

/// Where a panel is divided: at the kink nearest to its middle, else in the middle.
inline double parting_place(const PanelMap& map, std::span<const double> kinks, bool& kinked) {
  const double middle = 0.5 * (map.lo + map.hi), margin = 1e-9 * map.hi;
  double place = middle;
  kinked = false;
  for (const double kink : kinks)
    if (kink > map.lo + margin && kink < map.hi - margin &&
        (!kinked || std::abs(kink - middle) < std::abs(place - middle)))
      kinked = true, place = kink;
  return place;
}

/// The panel and those it is parted into, in rising order, appended to `panels`. `evaluate(f, values)` appends the OTFs
/// at frequencies f. It stops at the tolerance, or at `most` panels. A panel with a kink that the least degree does not
/// resolve is parted there: more points would not help.
template <class S, std::size_t N, class Evaluate>
void append_series(std::vector<SeriesPanel<S, N>>& panels, PanelMap map, double tolerance, std::size_t most,
                   std::span<const double> kinks, Evaluate& evaluate, int depth = 0) {
  constexpr int kDeepest = 40;
  bool kinked = false;
  const double parting = parting_place(map, kinks, kinked);
  constexpr int kFirst = kLeastDegree, kLast = kMostDegree;
  SeriesValues<S, N> values;
  std::vector<double> f;
  for (int n = kFirst;; n *= 2) {
    f.clear();
    for (int k = n == kFirst ? 0 : 1; k <= n; k += n == kFirst ? 1 : 2)
      f.push_back(map.lo + (map.hi - map.lo) * chebyshev_points(n).share[static_cast<std::size_t>(k)]);
    SeriesValues<S, N> fresh;
    evaluate(f, fresh);
    SeriesPanel<S, N> panel{map, {}, n, 0.0};
    for (std::size_t i = 0; i < N; ++i) {
      if (fresh[i].empty()) continue;  // not asked for
      if (n == kFirst) {
        values[i] = std::move(fresh[i]);
      } else {
        std::vector<Complex<S>> merged(static_cast<std::size_t>(n) + 1);
        for (std::size_t k = 0; k < merged.size(); ++k) merged[k] = k % 2 == 0 ? values[i][k / 2] : fresh[i][k / 2];
        values[i] = std::move(merged);
      }
      panel.otf[i] = make_series(values[i]);
      double largest = 1.0;
      for (const Complex<S>& h : values[i])
        largest = std::max({largest, std::abs(value_of(h.re)), std::abs(value_of(h.im))});
      panel.error = std::max(panel.error, tail(panel.otf[i]) / largest);
    }
    const bool last_chance = panels.size() >= most || depth >= kDeepest;
    if (panel.error <= tolerance || (n == kLast && last_chance)) {
      panels.push_back(std::move(panel));
      return;
    }
    if (n < kLast && (!kinked || last_chance)) continue;
    append_series<S, N>(panels, {map.lo, parting}, tolerance, most, kinks, evaluate, depth + 1);
    append_series<S, N>(panels, {parting, map.hi}, tolerance, most, kinks, evaluate, depth + 1);
    return;
  }
}

/// The series at the fine nodes.
template <class S>
std::vector<S> at_nodes(const std::vector<S>& coefficient, const FineNodes& nodes) {
  std::vector<S> value(nodes.t.size());
  add_products(nodes.basis.data(), coefficient, value);
  return value;
}

/// Values of real and imaginary parts; the latter is empty for a real series.
template <class S>
struct ComplexValues {
  std::vector<S> re, im;
  Complex<S> operator[](std::size_t i) const { return {re[i], im.empty() ? S(0) : im[i]}; }
};
template <class S>
ComplexValues<S> at_nodes(const ComplexSeries<S>& series, const FineNodes& nodes) {
  return {at_nodes(series.re, nodes), series.im.empty() ? std::vector<S>{} : at_nodes(series.im, nodes)};
}
template <class S>
ComplexValues<S> at_places(const ComplexSeries<S>& series, std::span<const double> t) {
  return {chebyshev_at(series.re, t), series.im.empty() ? std::vector<S>{} : chebyshev_at(series.im, t)};
}

}  // namespace mtf
