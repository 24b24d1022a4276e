// SPDX-License-Identifier: Apache-2.0
#include "mtf/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <list>
#include <map>
#include <mutex>
#include <thread>

#include "mtf/work/stop.h"

namespace mtf {

namespace {

/// Arenas that no call uses, by their number of threads. An arena is kept, since oneTBB 2021.8 does not give back all
/// the memory of one that ends (its issue 967), and starting one costs more than a small range. Each call has an arena
/// of its own: in a shared one a thread that waits for its pieces might take those of another call while it holds a
/// lock.
struct IdleArenas {
  std::mutex mutex;
  std::map<int, std::list<tbb::task_arena>> by_threads;
};

/// They are never destroyed: threads may still be in a call when the program ends.
IdleArenas& idle_arenas() {
  static IdleArenas& arenas = *new IdleArenas;
  return arenas;
}

/// An arena for one call, from the idle ones where there is one, and back to them.
class ArenaOfCall {
 public:
  explicit ArenaOfCall(int threads) {
    const std::lock_guard lock(idle_arenas().mutex);
    idle_ = &idle_arenas().by_threads[threads];
    if (idle_->empty()) {
      arena_.emplace_back(threads);
    } else {
      arena_.splice(arena_.begin(), *idle_, idle_->begin());
    }
  }
  ~ArenaOfCall() {
    const std::lock_guard lock(idle_arenas().mutex);
    idle_->splice(idle_->begin(), arena_);
  }
  ArenaOfCall(const ArenaOfCall&) = delete;
  ArenaOfCall& operator=(const ArenaOfCall&) = delete;

  tbb::task_arena& operator*() { return arena_.front(); }

 private:
  std::list<tbb::task_arena> arena_;  // the one of this call
  std::list<tbb::task_arena>* idle_;  // where it goes afterwards
};

}  // namespace

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
  ArenaOfCall arena(threads > 0 ? threads_of(threads) : tbb::task_arena::automatic);
  (*arena).execute([&] {
    tbb::parallel_for(std::int64_t{0}, pieces, [&](std::int64_t i) {
      const StopScope scope(stop);  // a thread of the arena has none
      piece(i);
    });
  });
}

}  // namespace mtf
