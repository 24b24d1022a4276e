// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which tile a worker takes next.

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace mtf {

/// Hands out the tiles in order, so that those at work together read the same rows of the scene, and none of a row of
/// tiles before all above it have been read: a reader may then drop the rows that only those needed.
class TileQueue {
 public:
  TileQueue(std::int64_t count, std::int64_t tiles_per_row) : count_(count), tiles_per_row_(tiles_per_row) {}
  /// The next tile, or `count` when there is none or one has failed.
  std::int64_t next() {
    std::unique_lock guard(lock_);
    changed_.wait(guard, [&] { return next_ >= count_ || read_ >= next_ / tiles_per_row_ * tiles_per_row_; });
    return next_ < count_ ? next_++ : count_;
  }
  /// Another tile has all of its samples.
  void was_read() {
    const std::scoped_lock guard(lock_);
    ++read_;
    changed_.notify_all();
  }
  void stop() {
    const std::scoped_lock guard(lock_);
    next_ = count_;
    changed_.notify_all();
  }

 private:
  std::mutex lock_;
  std::condition_variable changed_;
  std::int64_t count_, tiles_per_row_, next_ = 0, read_ = 0;
};

}  // namespace mtf
