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

/// A zero between neighbouring nodes lo and hi, where a series has the values h_lo and h_hi of different sign, within
/// about `near`. `values(places)`: many places at once cost little more than one. A straight line is left where what
/// the series bends between nodes no longer counts.
template <class Values>
double find_zero(double lo, double h_lo, double hi, double h_hi, double near, Values values) {
  constexpr std::size_t kPlaces = 8;
  const double bending = 1.0 / (8.0 * (hi - lo));
  while (bending * (hi - lo) * (hi - lo) > near) {
    std::array<double, kPlaces> t{};
    for (std::size_t i = 0; i < kPlaces; ++i) t[i] = lo + (hi - lo) * static_cast<double>(i + 1) / (kPlaces + 1.0);
    const std::vector<double> at = values(t);
    const auto after = std::find_if(at.begin(), at.end(), [&](double h) { return (h > 0.0) != (h_lo > 0.0); });
    const auto i = static_cast<std::size_t>(after - at.begin());
    if (i < kPlaces) hi = t[i], h_hi = at[i];
    if (i > 0) lo = t[i - 1], h_lo = at[i - 1];
  }
  return lo + (hi - lo) * h_lo / (h_lo - h_hi);
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
    const auto parts_along_a = [&](std::span<const double> t) {
      const ComplexValues<S> h = at_places(series, t);
      std::vector<double> parts;
      for (std::size_t k = 0; k < t.size(); ++k) parts.push_back(value_of(h[k].re) * re + value_of(h[k].im) * im);
      return parts;
    };
    zeros.push_back(find_zero(nodes.t[i - 1], square, nodes.t[i], now, near, parts_along_a));
  }
}

}  // namespace detail

}  // namespace mtf
