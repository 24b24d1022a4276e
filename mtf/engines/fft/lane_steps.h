// SPDX-License-Identifier: Apache-2.0
#pragma once

// One radix step of the transforms on rows of lanes (mtf/engines/fft/batched_fft.h).

#include <cstdint>
#include <vector>

namespace mtf {

/// Sequences that are transformed together, and numbers of one row.
inline constexpr int kLanes = 16;
inline constexpr int kRow = 2 * kLanes;

}  // namespace mtf

namespace mtf::lanes {

/// A step on blocks of radix x stride rows.
template <class S>
struct Step {
  int radix = 0;
  std::int64_t stride = 0;
  std::vector<S> twiddles;  ///< of row p > 0, factor j > 0: cos and sin of -2 pi p j / (radix stride)
};

/// `gather` is forward too, but reads row n of its one block from row rows[n] of `from`.
enum class Pass { forward, gather, inverse };

/// Takes `blocks` blocks of `data` through the step. Instantiated for float and double.
template <class S, Pass pass>
void run_step(const Step<S>& step, S* data, std::int64_t blocks, const S* from = nullptr,
              const std::int32_t* rows = nullptr);

}  // namespace mtf::lanes
