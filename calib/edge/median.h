// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace calib {

/// The middle value, the upper one of two, of at least one value. Their order changes.
template <class T>
T median(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The nth smallest (from 0) of numbers >= 0, whose order changes. Counting by the leading bits finds the few
/// candidates that have to be compared.
inline float nth_least(std::span<float> values, std::size_t nth) {
  constexpr int kShift = 20;  // the exponent and three bits of the fraction
  std::array<std::uint32_t, 1U << (32 - kShift)> count{};
  const auto begins = [](float value) { return std::bit_cast<std::uint32_t>(value) >> kShift; };
  for (const float value : values) ++count[begins(value)];
  std::uint32_t begin = 0;
  std::size_t below = 0;
  while (below + count[begin] <= nth) below += count[begin++];
  const auto end = std::partition(values.begin(), values.end(), [&](float value) { return begins(value) == begin; });
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(nth - below);
  std::nth_element(values.begin(), place, end);
  return *place;
}

}  // namespace calib
