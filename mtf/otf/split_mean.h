// SPDX-License-Identifier: Apache-2.0
#pragma once

// Means over a band, weighed by the electron rate, of what has kinks at wavelengths that are known. On each piece
// between two of them, [a, b] with lambda = a + (b - a) sin^2(pi (1 + t) / 4), the function is a series in T_k(t), in
// which the half powers of a distance to a kink are smooth (otf_series.h), and
//   integral over [a, b] of function = sum over k of c_k x integral of T_k
// for the product of rate and function where the rate is smooth there. Where the curves that make it (quantum
// efficiency, filters) have samples, the series is that of the function alone, with the integrals of rate x T_k:
// however many samples there are, the function is taken at as few wavelengths as it needs itself. Degrees 4, 8, 16 and
// 32 use the values of the one before; a piece that 32 do not resolve is halved. The error is taken from what the last
// doublings changed. (Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, ch. 4, 8 and 19.)

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "mtf/math/special.h"
#include "mtf/system.h"

namespace mtf {

/// A piece is given the degrees 2 to kMostBandDegree, each twice the one before.
inline constexpr int kMostBandDegree = 32;

/// The share of a piece's width below the points t = cos(pi j / kMostBandDegree).
const std::array<double, kMostBandDegree + 1>& band_shares();

class BandWeights {
 public:
  /// Does nothing where the band is the one before.
  void set(const Band& band);
  double lo_um() const { return lo_um_; }
  double hi_um() const { return hi_um_; }

  struct Piece {
    double a_um = 0.0, b_um = 0.0;
    std::array<double, kMostBandDegree + 1> moment{};  ///< integrals of rate x T_k
    int known = -1;                                    ///< largest k whose moment is known
  };
  /// The weights of the function's values at every (kMostBandDegree / degree)-th of the points, for the integral over
  /// the piece. They are valid until the next call.
  std::span<const double> weights(Piece& piece, int degree);

 private:
  /// The rate on a part of the band as a series of T_k of the place between its ends: within some 1e-15 of it.
  static constexpr std::size_t kRateTerms = 17;
  struct RateSeries {
    double lo_um = 0.0, hi_um = 0.0;
    std::array<double, kRateTerms> coefficient{};
    bool flat = true;  ///< true: the rate changes by no more than a third
    double at(double wavelength_um) const;
  };
  void add_series(double lo_um, double hi_um, double rounding, int depth);
  double rate_at(double wavelength_um) const;
  bool smooth(double a_um, double b_um) const;
  void moments(Piece& piece, int degree) const;

  double lo_um_ = 0.0, hi_um_ = 0.0;
  std::shared_ptr<const ElectronRate> rate_;
  std::vector<RateSeries> series_;  ///< in rising order; their integrals sum to 1
  Piece whole_;                     ///< the piece of the whole band, which is needed most often
  std::array<double, kMostBandDegree + 1> weight_{};
};

namespace detail {

template <class S, std::size_t N>
using BandValues = std::array<Complex<S>, N>;

/// Adds the integral over [a, b] to `mean`. Returns its error. `budget`: how many more values may be taken.
template <class S, std::size_t N, class At>
double add_piece(BandWeights& weights, double a_um, double b_um, double tolerance, At& at, BandValues<S, N>& mean,
                 int& budget) {
  constexpr int kFirst = 4, kMost = kMostBandDegree;
  constexpr double kNarrowest = 1e-13, kRounding = 1e-15;  // share of the wavelength; share of the values
  const auto& shares = band_shares();
  std::array<BandValues<S, N>, kMost + 1> value;
  BandWeights::Piece piece{.a_um = a_um, .b_um = b_um};
  const auto sum_of = [&](int degree) {
    BandValues<S, N> sum{};
    const std::span<const double> weight = weights.weights(piece, degree);
    const std::size_t step = static_cast<std::size_t>(kMost / degree);
    for (std::size_t j = 0; j < weight.size(); ++j)
      for (std::size_t n = 0; n < N; ++n) {
        const Complex<S>& v = value[j * step][n];
        sum[n].re += S(weight[j]) * v.re;
        sum[n].im += S(weight[j]) * v.im;
      }
    return sum;
  };
  const auto difference = [](const BandValues<S, N>& x, const BandValues<S, N>& y) {
    double most = 0.0;
    for (std::size_t n = 0; n < N; ++n) {
      const double one = std::hypot(value_of(x[n].re) - value_of(y[n].re), value_of(x[n].im) - value_of(y[n].im));
      if (!(one <= most)) most = one;  // NaN stays
    }
    return most;
  };
  BandValues<S, N> before{}, sum{};
  double error = 0.0, last_change = 0.0;
  for (int degree = kFirst;; degree *= 2) {
    const int step = kMost / degree;
    for (int j = 0; j <= kMost; j += step) {
      if (degree > kFirst && j % (2 * step) == 0) continue;
      const auto i = static_cast<std::size_t>(j);
      value[i] = at(a_um + (b_um - a_um) * shares[i]);
      --budget;
    }
    if (degree == kFirst) before = sum_of(degree / 2);
    sum = sum_of(degree);
    const double change = difference(sum, before);
    // Where a doubling changes much less than the one before did, what is left is less again; never by more than this.
    constexpr double kLeast = 0.02;
    error = last_change > 0.0 ? change * std::clamp(8.0 * change / last_change, kLeast, 1.0) : change;
    if (error <= tolerance) break;
    if (degree == kMost) {
      if (budget <= 0 || b_um - a_um <= kNarrowest * b_um) break;
      const double middle = 0.5 * (a_um + b_um);
      const double half = std::max(0.5 * tolerance, kRounding);
      error = add_piece<S, N>(weights, a_um, middle, half, at, mean, budget);
      return error + add_piece<S, N>(weights, middle, b_um, half, at, mean, budget);
    }
    before = sum;
    last_change = change;
  }
  for (std::size_t n = 0; n < N; ++n) mean[n] = mean[n] + sum[n];
  return error;
}

}  // namespace detail

template <class S, std::size_t N>
struct SplitMean {
  std::array<Complex<S>, N> value{};
  double error = 0.0;   ///< estimated error of the worst of them
  int wavelengths = 0;  ///< how many were taken
};

/// `at(lambda)` -> N values. `kinks_um`: rising; nothing is taken beyond `end_um`, from where on the function is 0.
/// It stops at the tolerance, or at some thousands of wavelengths.
template <class S, std::size_t N, class At>
SplitMean<S, N> split_mean(BandWeights& weights, std::span<const double> kinks_um, double end_um, double tolerance,
                           At at) {
  constexpr int kMostValues = 4000;
  constexpr double kFloor = 1e-14;  // rounding of the values
  const double end = std::min(end_um, weights.hi_um());
  SplitMean<S, N> mean;
  int budget = kMostValues;
  double from = weights.lo_um();
  const double share = std::max(0.25 * tolerance, kFloor);  // the share of one piece
  const auto add = [&](double to) {
    if (to - from <= 1e-14 * end) return;
    mean.error += detail::add_piece<S, N>(weights, from, to, share, at, mean.value, budget);
    from = to;
  };
  for (const double kink : kinks_um)
    if (kink > from && kink < end) add(kink);
  add(end);
  mean.wavelengths = kMostValues - budget;
  return mean;
}

}  // namespace mtf
