// SPDX-License-Identifier: Apache-2.0
#pragma once

// Functions without branches or calls, for loops that the compiler takes several lanes wide. Sines and cosines err by a
// few units in the last place of 1, exponentials by that much of themselves.

#include <array>
#include <bit>
#include <cstdint>
#include <numbers>

namespace calib {

/// A number that is added to it is rounded to the nearest whole one, which the lowest bits of the sum hold.
inline constexpr double kRound = 0x1.8p52;

/// The coefficients 1 / first!, 1 / (first + step)! and so on, every other one negative where the sign `turns`.
template <std::size_t kTerms>
constexpr std::array<double, kTerms> series(int first, int step, bool turns) {
  std::array<double, kTerms> term{};
  double factorial = 1.0;
  for (int k = 2; k <= first; ++k) factorial *= k;
  int at = first;
  for (std::size_t i = 0; i < kTerms; ++i) {
    term[i] = (turns && i % 2 == 1 ? -1.0 : 1.0) / factorial;
    for (int k = 0; k < step; ++k) factorial *= ++at;
  }
  return term;
}

template <std::size_t kTerms>
[[gnu::always_inline]] inline double polynomial(const std::array<double, kTerms>& term, double x) {
  double sum = term[kTerms - 1];
  for (std::size_t k = kTerms - 1; k-- > 0;) sum = sum * x + term[k];
  return sum;
}

struct SineCosine {
  double sin, cos;
};

/// |x| < 1e5.
[[gnu::always_inline]] inline SineCosine sine_cosine(double x) {
  constexpr double kPiHigh = 0x1.921fb54400000p1, kPiLow = 0x1.0b4611a626331p-33;  // 33 bits, so that n x high is exact
  constexpr std::array kSine = series<11>(1, 2, true), kCosine = series<11>(0, 2, true);
  const double rounded = x * std::numbers::inv_pi + kRound, n = rounded - kRound;
  const double r = (x - n * kPiHigh) - n * kPiLow, square = r * r;
  const std::uint64_t odd = std::bit_cast<std::uint64_t>(rounded) << 63;
  const auto turned = [odd](double value) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^ odd); };
  return {turned(r * polynomial(kSine, square)), turned(polynomial(kCosine, square))};
}

/// exp(x), |x| < 700.
[[gnu::always_inline]] inline double exponential(double x) {
  constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
  constexpr std::array kTerms = series<14>(0, 1, false);
  const double rounded = x * std::numbers::log2e + kRound, n = rounded - kRound;
  const double r = (x - n * kLn2High) - n * kLn2Low;
  const std::uint64_t power = (std::bit_cast<std::uint64_t>(rounded) + 1023) << 52;
  return polynomial(kTerms, r) * std::bit_cast<double>(power);
}

}  // namespace calib
