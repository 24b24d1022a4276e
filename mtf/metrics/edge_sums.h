// SPDX-License-Identifier: Apache-2.0
#pragma once

// Edge and line spread along an axis as sums over the nodes of a quadrature (formulas: resolution.h). Places in pixels.

#include <algorithm>
#include <cassert>
#include <type_traits>
#include <vector>

#include "mtf/math/special.h"
#include "mtf/otf/otf_series.h"

namespace mtf {
namespace detail {

inline constexpr std::size_t kEdgeLanes = 8;  ///< sums run side by side, as many on every machine

/// A term a frequency: cycles per pixel, 1/u, weighted parts of the OTF. As many as fill the lanes.
template <class S>
struct EdgeTerms {
  std::vector<S> u, per_u, re, im;
};

/// Sums of odd/u, even, u odd and u^2 even, where even = re cos - im sin and odd = re sin + im cos.
template <class S>
struct SpreadSums {
  S step{}, line{}, slope{}, curvature{};
};
// On whatever vectors the machine has.
SpreadSums<double> spread_sums(const EdgeTerms<double>& terms, const std::vector<double>& sine,
                               const std::vector<double>& cosine);
/// The first two of them at many places, from one to the next by a turn of each term.
void stepped_sums(const EdgeTerms<double>& terms, std::vector<double>& sine, std::vector<double>& cosine,
                  const std::vector<double>& turn_sine, const std::vector<double>& turn_cosine,
                  std::vector<double>& step, std::vector<double>& line);

template <class S>
SpreadSums<S> spread_sums(const EdgeTerms<S>& terms, const std::vector<S>& sine, const std::vector<S>& cosine) {
  SpreadSums<S> sums;
  for (std::size_t i = 0; i < terms.u.size(); ++i) {
    const S even = terms.re[i] * cosine[i] - terms.im[i] * sine[i];
    const S odd = terms.re[i] * sine[i] + terms.im[i] * cosine[i];
    sums.step += odd * terms.per_u[i];
    sums.line += even;
    sums.slope += terms.u[i] * odd;
    sums.curvature += terms.u[i] * terms.u[i] * even;
  }
  return sums;
}
template <class S>
void stepped_sums(const EdgeTerms<S>& terms, std::vector<S>& sine, std::vector<S>& cosine,
                  const std::vector<S>& turn_sine, const std::vector<S>& turn_cosine, std::vector<S>& step,
                  std::vector<S>& line) {
  for (std::size_t k = 0; k < step.size(); ++k)
    for (std::size_t i = 0; i < terms.u.size(); ++i) {
      const S s = sine[i], c = cosine[i];
      step[k] += terms.per_u[i] * (terms.re[i] * s + terms.im[i] * c);
      line[k] += terms.re[i] * c - terms.im[i] * s;
      sine[i] = s * turn_cosine[i] + c * turn_sine[i];
      cosine[i] = c * turn_cosine[i] - s * turn_sine[i];
    }
}

}  // namespace detail

/// The spreads at places a quarter of a pixel apart.
template <class S>
struct EdgeSamples {
  double first_px = 0.0;
  std::vector<S> esf, lsf;
};

template <class S>
class EdgeSums {
 public:
  static constexpr double kStep_px = 0.25;
  static constexpr double kFurthest_px = 1000.0;  ///< of the peak from the middle of the edge, which a tail takes away

  /// `pitch_mm`: scales frequencies to cycles per pixel. `near_px`: how short the last Newton step to a place is, which
  /// leaves its square.
  void clear(const S& pitch_mm, double near_px) {
    pitch_mm_ = pitch_mm;
    near_px_ = near_px;
    terms_.u.clear(), terms_.re.clear(), terms_.im.clear(), terms_.per_u.clear();
    real_ = true;
  }
  /// The nodes of a panel, with the OTF there. Their number is a multiple of kEdgeLanes.
  void add(const PanelMap& map, const FineNodes& nodes, const ComplexValues<S>& otf) {
    const double width = map.hi - map.lo;
    const std::size_t first = terms_.u.size(), count = nodes.share.size();
    for (auto* part : {&terms_.u, &terms_.per_u, &terms_.re, &terms_.im}) part->resize(first + count);
    for (std::size_t i = 0; i < count; ++i) {
      const S u = S(map.lo + width * nodes.share[i]) * pitch_mm_, weight = S(width * nodes.weight[i]) * pitch_mm_;
      terms_.u[first + i] = u;
      terms_.per_u[first + i] = S(1) / u;
      terms_.re[first + i] = weight * otf.re[i];
      terms_.im[first + i] = otf.im.empty() ? S(0) : S(weight * otf.im[i]);
    }
    real_ = real_ && otf.im.empty();
  }
  bool real() const { return real_; }

  /// All that one turn of every frequency gives.
  struct Spread {
    S esf{}, lsf{}, slope{}, curvature{};  ///< the lsf with its two derivatives
  };
  Spread at(const S& x) const {
    turn(x, sine_, cosine_);
    const auto [step, line, slope, curvature] = detail::spread_sums(terms_, sine_, cosine_);
    return {S(0.5) + step / S(kPi), S(2) * line, S(-4.0 * kPi) * slope, S(-8.0 * kPi * kPi) * curvature};
  }

  /// From x0 on, every quarter of a pixel: each frequency is turned from one place to the next.
  EdgeSamples<S> samples(const S& x0, int count) const {
    const auto n = static_cast<std::size_t>(count);
    EdgeSamples<S> out{value_of(x0), std::vector<S>(n), std::vector<S>(n)};
    turn(x0, sine_, cosine_);
    turn(S(kStep_px), turn_sine_, turn_cosine_);
    detail::stepped_sums(terms_, sine_, cosine_, turn_sine_, turn_cosine_, out.esf, out.lsf);
    for (std::size_t k = 0; k < n; ++k) {
      out.esf[k] = S(0.5) + out.esf[k] / S(kPi);
      out.lsf[k] = S(2) * out.lsf[k];
    }
    return out;
  }

  /// The place where the edge is at one half: exactly 0 for a real OTF, else searched about `near`.
  S centre(double near) const {
    if (real_) return S(0);
    const auto esf = [this](double x) { return value_of(at(S(x)).esf); };
    double x = near;
    for (int i = 0; i < 6; ++i) {  // Newton; mostly the edge is where the slowest waves put it
      const Spread here = at(S(x));
      const S step = (S(0.5) - here.esf) / here.lsf;
      if (!(value_of(here.lsf) > 0.0) || !(std::abs(value_of(step)) < 1.0)) break;
      if (std::abs(value_of(step)) < near_px_) return S(x) + step;
      x += value_of(step);
    }
    x = near;
    double lo = near - 1.0, hi = near + 1.0;
    constexpr int kDoublings = 20;
    for (int i = 0; i < kDoublings && esf(lo) > 0.5; ++i) lo -= hi - lo;
    for (int i = 0; i < kDoublings && esf(hi) < 0.5; ++i) hi += hi - lo;
    for (int i = 0; i < 100; ++i) {  // the same inside a bracket
      const Spread here = at(S(x));
      const double lsf = value_of(here.lsf);
      const S step = (S(0.5) - here.esf) / here.lsf;
      if (lsf > 0.0 && std::abs(value_of(step)) < near_px_) return S(x) + step;
      (value_of(here.esf) < 0.5 ? lo : hi) = x;
      const double next = x + value_of(step);
      x = lsf > 0.0 && next > lo && next < hi ? next : 0.5 * (lo + hi);
    }
    return S(x);
  }

  /// The peak of the lsf, searched about the edge in quarters of a pixel, and the samples around it; NaN where it is
  /// not within kFurthest_px. The value there does not depend on the place to first order, so it carries no derivative.
  struct Peak {
    S x{};
    EdgeSamples<S> around;
  };
  Peak peak(double centre) const {
    for (double extent = 1.5;; extent *= 2.0) {
      const int count = static_cast<int>(2.0 * extent / kStep_px) + 1;
      EdgeSamples<S> around = samples(S(centre - extent), count);
      const auto top = std::max_element(around.lsf.begin(), around.lsf.end(),
                                        [](const S& a, const S& b) { return value_of(a) < value_of(b); });
      const auto i = top - around.lsf.begin();
      const bool inside = i > 0 && i + 1 < count;
      if (!inside && extent < kFurthest_px) continue;
      if (!inside) return {S(std::nan("")), std::move(around)};
      const S x = falling_zero(around.first_px + kStep_px * static_cast<double>(i),
                               [](const Spread& here) { return std::pair(here.slope, here.curvature); });
      return {x, std::move(around)};
    }
  }
  /// The top of the edge near `x` (a zero of the lsf), within a quarter of a pixel; no derivative either.
  S top(double x) const {
    return falling_zero(x, [](const Spread& here) { return std::pair(here.lsf, here.slope); });
  }

  /// How far from the peak the lsf falls to `half` on the side of `sign`; NaN where it does not within 1e5 pixels. The
  /// samples give a first estimate.
  S half_width(const S& peak, const S& half, double sign, const EdgeSamples<S>& samples) const {
    const double half_value = value_of(half), top = value_of(peak);
    const auto spread = [&](double d) { return at(S(top + sign * d)); };
    double inside = 0.0, above = half_value, outside = 0.0, d = 0.0;
    const auto last = static_cast<std::ptrdiff_t>(samples.lsf.size()) - 1;
    const double from = (top - samples.first_px) / kStep_px;  // of the peak, in samples
    if (!std::isfinite(from)) return S(std::nan(""));
    for (auto i = static_cast<std::ptrdiff_t>(sign > 0.0 ? std::floor(from) + 1.0 : std::ceil(from) - 1.0);
         i >= 0 && i <= last && outside == 0.0; i += sign > 0.0 ? 1 : -1) {
      const double excess = value_of(samples.lsf[static_cast<std::size_t>(i)]) - half_value;
      const double distance = kStep_px * std::abs(static_cast<double>(i) - from);
      if (excess > 0.0)
        inside = distance, above = excess;
      else
        outside = distance, d = inside + (outside - inside) * above / (above - excess);
    }
    if (outside == 0.0) {  // beyond the samples
      outside = inside + kStep_px;
      for (int i = 0; value_of(spread(outside).lsf) > half_value; ++i, inside = outside, outside *= 1.5)
        if (i > 34) return S(std::nan(""));
      d = 0.5 * (inside + outside);
    }
    for (int i = 0; i < 100; ++i) {  // Newton inside a bracket
      const Spread here = spread(d);
      const S step = (half - here.lsf) / (S(sign) * here.slope);
      if (std::abs(value_of(step)) < near_px_) return S(d) + step;
      (value_of(here.lsf) > half_value ? inside : outside) = d;
      const double next = d + value_of(step);
      d = next > inside && next < outside ? next : 0.5 * (inside + outside);
    }
    return S(d);
  }

 private:
  /// A zero where a figure has its maximum: the figure errs by the square, so that sqrt(near_px_) is near enough.
  template <class Pair>
  S falling_zero(double start, Pair pair) const {
    const double near = std::sqrt(near_px_);
    double x = start;
    for (int i = 0; i < 50; ++i) {
      const auto [value, slope] = pair(at(S(x)));
      if (!(value_of(slope) < 0.0)) break;
      const double next = std::clamp(x - value_of(value) / value_of(slope), start - kStep_px, start + kStep_px);
      const bool last = std::abs(next - x) < near;
      x = next;
      if (last) break;
    }
    return S(x);
  }

  /// Sine and cosine of every frequency's turn at x.
  void turn(const S& x, std::vector<S>& sine, std::vector<S>& cosine) const {
    using std::cos;
    using std::sin;
    const std::vector<S>& u = terms_.u;
    assert(u.size() % detail::kEdgeLanes == 0);
    sine.resize(u.size());
    cosine.resize(u.size());
    if constexpr (std::is_same_v<S, double>) {
      turns_.resize(u.size());
      for (std::size_t i = 0; i < u.size(); ++i) turns_[i] = u[i] * x;
      sin_cos_turns(turns_, sine, cosine);
    } else {
      for (std::size_t i = 0; i < u.size(); ++i) {
        const S angle = S(2.0 * kPi) * u[i] * x;
        sine[i] = sin(angle);
        cosine[i] = cos(angle);
      }
    }
  }

  S pitch_mm_{};
  double near_px_ = 0.0;
  detail::EdgeTerms<S> terms_;
  mutable std::vector<S> sine_, cosine_, turn_sine_, turn_cosine_, turns_;  ///< scratch: sums belong to one thread
  bool real_ = true;
};

}  // namespace mtf
