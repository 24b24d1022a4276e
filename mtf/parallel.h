// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

namespace mtf {

/// The number of threads that is meant: `asked`, at most 4096, or all cores where that is 0 or less.
int threads_of(int asked);

/// Calls `work(begin, end)` over pieces of [0, count) of at most `chunk` on up to `threads` threads (0 = all cores).
/// Results may not depend on how the range is cut. With one thread the pieces run in order on the calling thread.
void parallel_for(std::int64_t count, std::int64_t chunk, int threads,
                  const std::function<void(std::int64_t, std::int64_t)>& work);

/// The same, `work(i)` for each i of [0, count).
void parallel_for_each(std::int64_t count, std::int64_t chunk, int threads, const auto& work) {
  parallel_for(count, chunk, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) work(i);
  });
}

}  // namespace mtf
