// SPDX-License-Identifier: Apache-2.0
#include "mtf/grid.h"

#include <algorithm>
#include <cmath>

namespace mtf {

std::vector<double> FrequencyAxis::half_frequencies() const {
  std::vector<double> f(static_cast<std::size_t>(half_count()));
  for (std::size_t k = 0; k < f.size(); ++k) f[k] = cy_mm(static_cast<std::int64_t>(k));
  return f;
}

std::vector<double> FrequencyAxis::all_frequencies() const {
  if (basis == Basis::cosine) return half_frequencies();
  std::vector<double> f(static_cast<std::size_t>(length + (length % 2 == 0 ? 1 : 0)));
  for (std::size_t r = 0; r < f.size(); ++r) f[r] = cy_mm(signed_index(static_cast<std::int64_t>(r)));
  return f;
}

double samples_per_pixel(const SampleGrid& in, const SampleGrid& out) {
  return std::max(1.0, std::ceil(out.step_x_um / in.step_x_um) * std::ceil(out.step_y_um / in.step_y_um));
}

std::optional<PitchRatio> pitch_ratio(double pitch_um, double step_um) {
  constexpr std::int64_t kLargestDenominator = 64;
  constexpr double kRoundingOfRatio = 4e-16;  // of a quotient of two decimals
  const double ratio = pitch_um / step_um;
  for (std::int64_t q = 1; q <= kLargestDenominator; ++q) {
    const double p = std::round(ratio * static_cast<double>(q));
    if (p >= 1.0 && p < 1e9 && std::abs(ratio * static_cast<double>(q) - p) <= kRoundingOfRatio * p)
      return PitchRatio{static_cast<std::int64_t>(p), q};
  }
  return std::nullopt;
}

bool is_whole(double pitches) { return pitches > 0.5 && std::abs(pitches - std::round(pitches)) <= kWholeEpsilon; }

bool is_smooth(std::int64_t n) {
  for (const std::int64_t p : {2, 3, 5, 7})
    while (n % p == 0) n /= p;
  return n == 1;
}

std::int64_t next_smooth(std::int64_t n) {
  while (!is_smooth(n)) ++n;
  return n;
}

}  // namespace mtf
