// SPDX-License-Identifier: Apache-2.0
#pragma once

// A pupil that rims of other lenses cut, seen from off the axis (cat's eye): the disc or ring of outer radius 1 within
// a circle of radius R whose centre lies at (s, 0). Its OTF with a wavefront W in waves,
//   otf = 1/A integral over p of exp(2 pi i [W(p + nu) - W(p - nu)]),  p + nu and p - nu within the pupil of area A
// (Goodman, Introduction to Fourier Optics, ch. 6). Both lie within the pupil where p lies within four discs, less
// those two that the obscuration makes of it, by inclusion and exclusion. An intersection of discs is convex, its
// outline a few arcs g(t), and an integral over it is the sum over them of that over the triangles from p = 0 to the
// arc,
//   integral over t of (g x g') integral over s from 0 to 1 of s F(s g(t)),
// signed, so that 0 need not lie within. For polynomials W both integrands are entire: Gauss-Legendre converges
// geometrically, with as many nodes as the phase asks for. A template over S: derivatives follow the arcs' ends.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mtf/components/pupil/wavefront_pupil.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace mtf {

/// As PupilPolynomial, with coefficients that have derivatives.
template <class T>
struct WavePolynomial {
  int degree = 0;
  std::array<std::array<T, PupilPolynomial::kMaxDegree + 1>, PupilPolynomial::kMaxDegree + 1> a{};

  void add(const PupilPolynomial& term, const T& factor) {
    degree = std::max(degree, term.degree);
    each([&](T& c, std::size_t i, std::size_t j) {
      if (term.a[i][j] != 0.0) c += factor * T(term.a[i][j]);
    });
  }
  /// f(coefficient, i, j) of each term x^i y^j.
  void each(const auto& f) {
    const auto d = static_cast<std::size_t>(degree);
    for (std::size_t i = 0; i <= d; ++i)
      for (std::size_t j = 0; i + j <= d; ++j) f(a[i][j], i, j);
  }
  /// W(p + nu) - W(p - nu).
  WavePolynomial difference(const Freq<T>& nu) {
    WavePolynomial d{degree, {}};
    each([&](const T& c, std::size_t i, std::size_t j) {
      T x(2);  // 2 C(i, k) nu_x^k C(j, l) nu_y^l for odd k + l
      for (std::size_t k = 0; k <= i; ++k) {
        T both = x;
        for (std::size_t l = 0; l <= j; ++l) {
          if ((k + l) % 2 == 1) d.a[i - k][j - l] += c * both;
          both *= nu.y * T(static_cast<double>(j - l) / static_cast<double>(l + 1));
        }
        x *= nu.x * T(static_cast<double>(i - k) / static_cast<double>(k + 1));
      }
    });
    return d;
  }
};

namespace detail {

template <class T>
struct PupilDisc {
  T x, y, r;
};

/// Of the outline of an intersection of discs, from one angle to a larger one.
template <class T>
struct PupilArc {
  PupilDisc<T> disc;
  T begin, end;
};

/// Discs that differ by less count once, as all do at nu = 0, and those that cross by less touch: the ends of so short
/// arcs would be rounding.
inline constexpr double kSameDisc = 1e-13;

/// The outline; nothing where the discs have no place in common.
template <class T>
std::vector<PupilArc<T>> outline_of(const std::vector<PupilDisc<T>>& given) {
  using std::acos, std::atan2, std::sqrt;
  const auto gap = [](const PupilDisc<T>& a, const PupilDisc<T>& b) {
    return std::hypot(value_of(b.x) - value_of(a.x), value_of(b.y) - value_of(a.y));
  };
  std::vector<PupilDisc<T>> discs;
  for (const PupilDisc<T>& disc : given)
    if (std::ranges::none_of(discs, [&](const PupilDisc<T>& other) {
          return gap(disc, other) + std::abs(value_of(disc.r) - value_of(other.r)) < kSameDisc;
        }))
      discs.push_back(disc);
  std::vector<PupilArc<T>> arcs;
  for (const PupilDisc<T>& disc : discs) {
    std::vector<T> ends;
    bool whole_outside = false;
    for (const PupilDisc<T>& other : discs) {
      if (&other == &disc) continue;
      const double d = gap(disc, other), r = value_of(disc.r), o = value_of(other.r);
      if (d >= r + o - kSameDisc) return {};
      if (d <= o - r + kSameDisc) continue;  // within it
      whole_outside = whole_outside || d <= r - o + kSameDisc;
      if (whole_outside) break;
      const T x = other.x - disc.x, y = other.y - disc.y, square = x * x + y * y;
      const T middle = atan2(y, x);
      const T half = acos((square + (disc.r - other.r) * (disc.r + other.r)) / (T(2) * sqrt(square) * disc.r));
      for (T end : {T(middle - half), T(middle + half)}) {
        if (value_of(end) < -kPi) end += T(2.0 * kPi);
        if (value_of(end) > kPi) end -= T(2.0 * kPi);
        ends.push_back(end);
      }
    }
    if (whole_outside) continue;
    std::ranges::sort(ends, {}, [](const T& end) { return value_of(end); });
    if (ends.empty()) ends.push_back(T(-kPi));
    ends.push_back(ends.front() + T(2.0 * kPi));
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      const double t = 0.5 * (value_of(ends[i]) + value_of(ends[i + 1])), r = value_of(disc.r);
      const double x = value_of(disc.x) + r * std::cos(t), y = value_of(disc.y) + r * std::sin(t);
      if (std::ranges::all_of(discs, [&](const PupilDisc<T>& other) {
            return &other == &disc ||
                   std::hypot(x - value_of(other.x), y - value_of(other.y)) <= value_of(other.r) + 0.5 * kSameDisc;
          }))
        arcs.push_back({disc, ends[i], ends[i + 1]});
    }
  }
  return arcs;
}

template <class T>
T area_of(const std::vector<PupilArc<T>>& arcs) {
  using std::cos, std::sin;
  T twice(0);
  for (const auto& [disc, begin, end] : arcs)
    twice += disc.r * (disc.x * (sin(end) - sin(begin)) - disc.y * (cos(end) - cos(begin)) + disc.r * (end - begin));
  return T(0.5) * twice;
}

/// Of d along the ray through a point, the coefficients of the powers of the distance, 1 at the point.
template <class T>
std::array<T, PupilPolynomial::kMaxDegree + 1> along_ray(const WavePolynomial<T>& d, const T& x, const T& y) {
  std::array<T, PupilPolynomial::kMaxDegree + 1> row{};
  for (int k = 0; k <= d.degree; ++k) {
    T sum(0), power(1);  // of y
    const auto n = static_cast<std::size_t>(k);
    std::array<T, PupilPolynomial::kMaxDegree + 1> of_x{};
    of_x[0] = T(1);
    for (std::size_t i = 1; i <= n; ++i) of_x[i] = of_x[i - 1] * x;
    for (std::size_t j = 0; j <= n; ++j, power *= y) sum += d.a[n - j][j] * of_x[n - j] * power;
    row[n] = sum;
  }
  return row;
}

/// Integral of exp(2 pi i d) - 1 over the area within the arcs.
template <class T>
Complex<T> phase_integral(const std::vector<PupilArc<T>>& arcs, const WavePolynomial<T>& d, double accuracy) {
  using std::cos, std::sin;
  const double digits = -std::log10(accuracy), growth = 1.0 + 0.04 * d.degree, start = 1.0 + 0.12 * d.degree;
  const auto nodes = [&](double radians, double least) -> const GaussRule& {
    const double n = growth * radians + 3.0 * std::cbrt(radians) + start * least;
    return gauss_legendre(std::clamp(2 * static_cast<int>(std::ceil(0.5 * n)), 4, kMostGaussNodes));
  };
  Complex<T> sum{T(0), T(0)};
  for (const auto& [disc, begin, end] : arcs) {
    const T span = end - begin;
    // The steepest phase along rays and along the arc, from samples.
    double radial = 0.0, along = 0.0, before = 0.0;
    const int samples = 2 * (d.degree + 4);
    for (int k = 0; k <= samples; ++k) {
      const T t = begin + span * T(static_cast<double>(k) / samples);
      const auto row = along_ray(d, T(disc.x + disc.r * cos(t)), T(disc.y + disc.r * sin(t)));
      double slope = 0.0, there = 0.0;
      for (std::size_t i = 0; i < row.size(); ++i) {
        slope += static_cast<double>(i) * std::abs(value_of(row[i]));
        there += value_of(row[i]);
      }
      radial = std::max(radial, slope);
      if (k > 0) along = std::max(along, std::abs(there - before) * samples);
      before = there;
    }
    const GaussRule& across = nodes(kPi * along, 1.1 * digits + 1.5 * value_of(span));
    const GaussRule& out = nodes(kPi * radial, 0.9 * digits);
    std::vector<double> share, weight, re(out.node.size()), im(out.node.size());
    for (std::size_t k = 0; k < out.node.size(); ++k) {
      share.push_back(0.5 * (1.0 + out.node[k]));
      weight.push_back(share[k] * out.weight[k]);  // without the 1/2 of the interval
    }
    for (std::size_t i = 0; i < across.node.size(); ++i) {
      const T t = begin + T(0.5) * span * T(1.0 + across.node[i]), c = cos(t), s = sin(t);
      const T x = disc.x + disc.r * c, y = disc.y + disc.r * s;
      const auto row = along_ray(d, x, y);
      Complex<T> ray{T(0), T(0)};
      if constexpr (std::is_same_v<T, double>) {
        weighted_turns(row.data(), d.degree, share.data(), weight.data(), share.size(), re.data(), im.data());
        for (std::size_t k = 0; k < share.size(); ++k) ray = ray + Complex<T>{re[k], im[k]};
      } else {
        for (std::size_t k = 0; k < share.size(); ++k) {
          T cycles = row[static_cast<std::size_t>(d.degree)];
          for (int m = d.degree - 1; m >= 0; --m) cycles = cycles * T(share[k]) + row[static_cast<std::size_t>(m)];
          const T half = T(kPi) * (cycles - T(std::nearbyint(value_of(cycles)))), sine = sin(half);
          ray = ray + Complex<T>{T(-2.0 * weight[k]) * sine * sine, T(2.0 * weight[k]) * sine * cos(half)};
        }
      }
      const T jacobian = T(0.25 * across.weight[i]) * span * disc.r * (disc.x * c + disc.y * s + disc.r);
      sum = sum + Complex<T>{jacobian * ray.re, jacobian * ray.im};
    }
  }
  return sum;
}

}  // namespace detail

/// A circle that cuts a pupil: its radius, and the place of its centre on the x axis.
template <class T>
struct PupilRim {
  T radius, shift;

  /// Whether it leaves the disc of radius 1 whole.
  bool is_idle() const { return std::abs(value_of(shift)) <= value_of(radius) - 1.0; }
  /// Half the diameter of what it leaves of that disc: the cutoff, as a share of that of the disc.
  double half_diameter() const {
    const double r = value_of(radius), d = std::abs(value_of(shift));
    if (is_idle()) return 1.0;
    if (d <= 1.0 - r) return r;
    if (d >= 1.0 + r) return 0.0;
    const double crossing = (d * d + 1.0 - r * r) / (2.0 * d);  // of the circles, along x
    return crossing <= 0.0 ? 1.0 : crossing >= d ? r : std::sqrt((1.0 - crossing) * (1.0 + crossing));
  }
  /// A number of the shape that is left: where it changes, OTFs have kinks as functions of the shift.
  int shape(double obscuration) const {
    if (is_idle()) return 0;
    const bool narrower = half_diameter()<1.0, hole = std::abs(value_of(shift))> value_of(radius) - obscuration;
    return 1 + (narrower ? 1 : 0) + (hole ? 2 : 0);
  }
};

/// Area of the pupil, with an obscuration e.
template <class T>
T cut_pupil_area(const PupilRim<T>& rim, const T& obscuration) {
  std::vector<detail::PupilDisc<T>> discs{{T(0), T(0), T(1)}, {rim.shift, T(0), rim.radius}};
  const T whole = detail::area_of(detail::outline_of(discs));
  if (!(value_of(obscuration) > 0.0)) return whole;
  discs.push_back({T(0), T(0), obscuration});
  return whole - detail::area_of(detail::outline_of(discs));
}

/// Share of the area of the whole pupil that the rim leaves.
inline double pupil_share(const PupilRim<double>& rim, double obscuration) {
  return rim.is_idle() ? 1.0 : cut_pupil_area(rim, obscuration) / (kPi * (1.0 - obscuration * obscuration));
}

/// Absolute error about `accuracy`, over the share of the area that the pupil has. 0 where the pupils do not overlap.
template <class T>
Complex<T> cut_pupil_otf(WavePolynomial<T> wavefront, const Freq<T>& nu, const T& obscuration, const PupilRim<T>& rim,
                         double accuracy = 1e-13) {
  if (!(std::hypot(value_of(nu.x), value_of(nu.y)) < rim.half_diameter())) return {T(0), T(0)};
  const WavePolynomial<T> d = wavefront.difference(nu);
  const std::vector<detail::PupilDisc<T>> pupils{{-nu.x, -nu.y, T(1)},
                                                 {nu.x, nu.y, T(1)},
                                                 {rim.shift - nu.x, -nu.y, rim.radius},
                                                 {rim.shift + nu.x, nu.y, rim.radius}};
  Complex<T> sum{T(0), T(0)};
  const auto add = [&](double sign, std::initializer_list<double> holes) {
    std::vector<detail::PupilDisc<T>> discs = pupils;
    for (const double side : holes) discs.push_back({T(side) * nu.x, T(side) * nu.y, obscuration});
    const auto arcs = detail::outline_of(discs);
    const Complex<T> phase = detail::phase_integral(arcs, d, accuracy);
    sum = sum + Complex<T>{T(sign) * (phase.re + detail::area_of(arcs)), T(sign) * phase.im};
  };
  add(1.0, {});
  if (value_of(obscuration) > 0.0) add(-1.0, {-1.0}), add(-1.0, {1.0}), add(1.0, {-1.0, 1.0});
  const T area = cut_pupil_area(rim, obscuration);
  return {sum.re / area, sum.im / area};
}

}  // namespace mtf
