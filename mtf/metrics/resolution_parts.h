// SPDX-License-Identifier: Apache-2.0
#pragma once

// What resolution_impl.h works with: the series of an axis, and where their moduli have kinks.

#include "mtf/otf/otf_series.h"

namespace mtf {
namespace detail {

template <class S>
S modulus(const Complex<S>& h) {
  using std::sqrt;
  if (value_of(h.im) == 0.0) return value_of(h.re) < 0.0 ? S(-h.re) : h.re;
  return sqrt(h.re * h.re + h.im * h.im);
}

inline constexpr std::size_t kSystem = 0, kPresample = 1, kUnfiltered = 2;  ///< OTFs of a panel
inline constexpr std::size_t kOtfs = 3;

/// Both along an axis, and what they are at nodes fine enough for all integrals.
template <class S>
struct AxisPanel {
  SeriesPanel<S, kOtfs> series;
  const FineNodes* nodes = nullptr;
  ComplexValues<S> system, presample, unfiltered;
};

/// A zero of `value` between lo and hi, where it has the values h_lo and h_hi of different sign, within `near`.
template <class Value>
double find_zero(double lo, double h_lo, double hi, double h_hi, double near, Value value) {
  double t = hi;
  for (int i = 0; i < 80 && hi - lo > near; ++i) {  // Illinois: an end that is kept twice counts half
    const double last = t;
    t = lo + (hi - lo) * h_lo / (h_lo - h_hi);
    if (std::abs(t - last) < near) break;
    const double at = value(t);
    if (at == 0.0) break;
    if ((at > 0.0) == (h_lo > 0.0))
      lo = t, h_lo = at, h_hi *= 0.5;
    else
      hi = t, h_hi = at, h_lo *= 0.5;
  }
  return t;
}

/// Where a series goes through 0 between the nodes and turns by half a cycle, but for what is below its own error:
/// there its modulus has a kink. Within `near`: integrals up to it err by the square.
template <class S>
void append_zeros(const ComplexSeries<S>& series, const ComplexValues<S>& values, const FineNodes& nodes, double error,
                  double near, std::vector<double>& zeros) {
  for (std::size_t i = 1; i < values.re.size(); ++i) {
    const Complex<S> a = values[i - 1], b = values[i];
    const double re = value_of(a.re), im = value_of(a.im), square = re * re + im * im;
    const double now = value_of(b.re) * re + value_of(b.im) * im;  // of b along a
    if (!(now < 0.0 &&
          std::max(square, value_of(b.re) * value_of(b.re) + value_of(b.im) * value_of(b.im)) > error * error))
      continue;
    const auto part_along_a = [&](double t) {
      const Complex<S> h = series.at(t);
      return value_of(h.re) * re + value_of(h.im) * im;
    };
    zeros.push_back(find_zero(nodes.t[i - 1], square, nodes.t[i], now, near, part_along_a));
  }
}

}  // namespace detail

}  // namespace mtf
