// SPDX-License-Identifier: Apache-2.0
#pragma once

// An exponential for loops that the compiler vectorises, which a call of std::exp would prevent: without branches or
// calls. Its relative error is below 5e-16 (tests/calib/test_reference_step.cpp). For sines and cosines of many angles
// see mtf/math/special.h.

#include <array>
#include <bit>
#include <cstdint>
#include <numbers>

namespace calib {

/// exp(x) for |x| < 700, as 2^n exp(r): ln 2 is taken off n times in two parts, the first of 33 bits so that n times it
/// is exact; 14 terms of the Taylor series of exp(r), |r| <= ln(2) / 2, leave 4e-18.
[[gnu::always_inline]] inline double exponential(double x) {
  constexpr double kRound = 0x1.8p52;  // a sum with it is rounded to a whole number, which its lowest bits hold
  constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
  constexpr auto kTaylor = [] {
    std::array<double, 14> term{1.0};
    double factorial = 1.0;
    for (std::size_t k = 1; k < term.size(); ++k) term[k] = 1.0 / (factorial *= static_cast<double>(k));
    return term;
  }();
  const double rounded = x * std::numbers::log2e + kRound, n = rounded - kRound;
  const double r = (x - n * kLn2High) - n * kLn2Low;
  double sum = kTaylor.back();
  for (std::size_t k = kTaylor.size() - 1; k-- > 0;) sum = sum * r + kTaylor[k];
  const std::uint64_t power = (std::bit_cast<std::uint64_t>(rounded) + 1023) << 52;
  return sum * std::bit_cast<double>(power);
}

}  // namespace calib
