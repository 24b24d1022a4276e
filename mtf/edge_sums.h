// SPDX-License-Identifier: Apache-2.0
#pragma once

// Edge and line spread along an axis as sums over the nodes of a quadrature (formulas: resolution.h). Places in pixels.

#include <vector>

#include "mtf/special.h"

namespace mtf {

/// The spreads at places a quarter of a pixel apart.
template <class S>
struct EdgeSamples {
  std::vector<S> esf, lsf;
};

template <class S>
class EdgeSums {
 public:
  static constexpr double kStep_px = 0.25;

  /// `pitch_mm`: scales frequencies to cycles per pixel.
  void clear(const S& pitch_mm) {
    pitch_mm_ = pitch_mm;
    u_.clear(), re_.clear(), im_.clear();
    real_ = true;
  }
  void add(double f_cy_mm, double weight_cy_mm, const Complex<S>& h) {
    u_.push_back(S(f_cy_mm) * pitch_mm_);
    const S weight = S(weight_cy_mm) * pitch_mm_;
    re_.push_back(weight * h.re);
    im_.push_back(weight * h.im);
    real_ = real_ && value_of(h.im) == 0.0;
  }
  bool real() const { return real_; }

  /// All that one turn of every frequency gives.
  struct Spread {
    S esf{}, lsf{}, slope{}, curvature{};  ///< the lsf with its two derivatives
  };
  Spread at(const S& x) const {
    using std::cos;
    using std::sin;
    S step{}, line{}, slope{}, curvature{};
    for (std::size_t i = 0; i < u_.size(); ++i) {
      const S angle = S(2.0 * kPi) * u_[i] * x, c = cos(angle), s = sin(angle);
      const S even = re_[i] * c - im_[i] * s, odd = re_[i] * s + im_[i] * c;
      step += odd / u_[i];
      line += even;
      slope += u_[i] * odd;
      curvature += u_[i] * u_[i] * even;
    }
    return {S(0.5) + step / S(kPi), S(2) * line, S(-4.0 * kPi) * slope, S(-8.0 * kPi * kPi) * curvature};
  }

  /// From x0 on, every quarter of a pixel: each frequency is turned from one place to the next.
  EdgeSamples<S> samples(const S& x0, int count) const {
    using std::cos;
    using std::sin;
    const auto n = static_cast<std::size_t>(count);
    EdgeSamples<S> out{std::vector<S>(n, S(0.5)), std::vector<S>(n, S(0))};
    for (std::size_t i = 0; i < u_.size(); ++i) {
      const S start = S(2.0 * kPi) * u_[i] * x0, turn = S(2.0 * kPi * kStep_px) * u_[i];
      const bool origin = value_of(start) == 0.0 && real_;
      S s = origin ? S(0) : S(sin(start)), c = origin ? S(1) : S(cos(start));
      const S ds = sin(turn), dc = cos(turn), scale = S(1.0 / kPi) / u_[i];
      const S re = re_[i], im = im_[i], re_esf = re * scale, im_esf = im * scale;
      for (std::size_t k = 0; k < n; ++k) {
        out.esf[k] += re_esf * s + im_esf * c;
        out.lsf[k] += S(2) * (re * c - im * s);
        const S next = s * dc + c * ds;
        c = c * dc - s * ds;
        s = next;
      }
    }
    return out;
  }

  /// The place where the edge is at one half, near 0: exactly 0 for a real OTF.
  S centre() const {
    if (real_) return S(0);
    double x = 0.0;
    for (int i = 0; i < 50; ++i) {
      const Spread here = at(S(x));
      if (!(value_of(here.lsf) > 0.0)) break;
      const S step = (S(0.5) - here.esf) / here.lsf;
      if (std::abs(value_of(step)) < kNear_px) return S(x) + step;
      x += std::clamp(value_of(step), -2.0, 2.0);
    }
    return S(x);
  }

  /// The peak of the lsf near `x`, and the top of the edge near `x` (a zero of the lsf), each within a quarter of a
  /// pixel. What is read there does not depend on the place to first order: it carries no derivative.
  S peak(double x) const {
    return falling_zero(x, [](const Spread& here) { return std::pair(here.slope, here.curvature); });
  }
  S top(double x) const {
    return falling_zero(x, [](const Spread& here) { return std::pair(here.lsf, here.slope); });
  }

  /// How far from the peak the lsf falls to `half` on the side of `sign`; NaN where it does not within 1e5 pixels.
  /// `inside`: a distance where it has not.
  S half_width(const S& peak, const S& half, double sign, double inside) const {
    const double level = value_of(half), top = value_of(peak);
    double outside = inside + kStep_px;
    const auto spread = [&](double d) { return at(S(top + sign * d)); };
    for (int i = 0; value_of(spread(outside).lsf) > level; ++i, inside = outside, outside *= 1.5)
      if (i > 34) return S(std::nan(""));
    double d = 0.5 * (inside + outside);
    for (int i = 0; i < 100; ++i) {  // Newton inside a bracket
      const Spread here = spread(d);
      const S step = (half - here.lsf) / (S(sign) * here.slope);
      if (std::abs(value_of(step)) < kNear_px) return S(d) + step;
      (value_of(here.lsf) > level ? inside : outside) = d;
      const double next = d + value_of(step);
      d = next > inside && next < outside ? next : 0.5 * (inside + outside);
    }
    return S(d);
  }

 private:
  static constexpr double kNear_px = 1e-6;  ///< a Newton step that short leaves its square

  template <class Pair>
  S falling_zero(double start, Pair pair) const {
    double x = start;
    for (int i = 0; i < 50; ++i) {
      const auto [value, slope] = pair(at(S(x)));
      if (!(value_of(slope) < 0.0)) break;
      const double next = std::clamp(x - value_of(value) / value_of(slope), start - kStep_px, start + kStep_px);
      const bool near = std::abs(next - x) < kNear_px;
      x = next;
      if (near) break;
    }
    return S(x);
  }

  S pitch_mm_{};
  std::vector<S> u_, re_, im_;  ///< re_, im_ weighted
  bool real_ = true;
};

}  // namespace mtf
