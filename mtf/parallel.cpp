// SPDX-License-Identifier: Apache-2.0
#include "mtf/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <thread>

#include "mtf/work/stop.h"

namespace mtf {

int threads_of(int asked) {
  // An arena reserves memory for each of its threads before it runs any.
  constexpr int kMost = 4096;
  return asked > 0 ? std::min(asked, kMost) : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

void parallel_for(std::int64_t count, std::int64_t chunk, int threads,
                  const std::function<void(std::int64_t, std::int64_t)>& work) {
  const std::int64_t pieces = (count + chunk - 1) / chunk;
  const auto piece = [&](std::int64_t i) {
    require_going_on();
    work(i * chunk, std::min(count, (i + 1) * chunk));
  };
  if (threads == 1 || pieces <= 1) {
    for (std::int64_t i = 0; i < pieces; ++i) piece(i);
    return;
  }
  const std::atomic<bool>* const stop = stop_flag();
  tbb::task_arena arena(threads > 0 ? threads_of(threads) : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::int64_t{0}, pieces, [&](std::int64_t i) {
      const StopScope scope(stop);  // a thread of the arena has none
      piece(i);
    });
  });
}

}  // namespace mtf
