// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tests of random numbers. Every result is in standard deviations of its distribution by chance; with fixed seeds, more
// than 4.5 is a fault.

#include <cmath>
#include <cstddef>
#include <span>

namespace radiometry::test {

inline constexpr double kMostSigmas = 4.5;

/// Chi-square of observed against expected numbers, both summing to the same, by the cube root of Wilson and Hilferty.
inline double chi_square_sigmas(std::span<const double> observed, std::span<const double> expected) {
  double sum = 0.0;
  for (std::size_t i = 0; i < observed.size(); ++i) sum += std::pow(observed[i] - expected[i], 2) / expected[i];
  const double dof = static_cast<double>(observed.size()) - 1.0, c = 2.0 / (9.0 * dof);
  return (std::cbrt(sum / dof) - (1.0 - c)) / std::sqrt(c);
}

struct Moments {
  double mean = 0.0, variance = 0.0;
};

template <class T>
Moments moments(std::span<const T> values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const T v : values) sum += static_cast<double>(v);
  for (const T v : values) squares += std::pow(static_cast<double>(v) - sum / n, 2);
  return {sum / n, squares / (n - 1.0)};
}

/// Correlation of two samples in sigmas, x sqrt(n).
template <class T>
double correlation_sigmas(std::span<const T> a, std::span<const T> b) {
  const Moments ma = moments(a), mb = moments(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (static_cast<double>(a[i]) - ma.mean) * (static_cast<double>(b[i]) - mb.mean);
  return sum / std::sqrt(ma.variance * mb.variance * static_cast<double>(a.size()));
}

}  // namespace radiometry::test
