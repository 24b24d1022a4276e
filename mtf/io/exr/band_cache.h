// SPDX-License-Identifier: Apache-2.0
#pragma once

// Decoded bands of rows for threads that read overlapping ranges of them, top to bottom as a whole. No band is decoded
// twice for readers that go down the file together:
//   - a reader pins its range before it starts, so that it stays in memory while it is read; it waits for others
//     to finish where the pinned bands would be more than are kept;
//   - several readers of the same bands share the decoding: each takes the next band that nobody has begun;
//   - where memory is needed the topmost band that nobody reads is dropped, and its memory is used again.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "mtf/image.h"

namespace mtf::io {

using Band = std::vector<Image>;  // a plane a channel

class BandCache {
 public:
  /// Fills a band, whose planes are those of another band or, the first time, none. Called from several threads at
  /// once, never twice at once for one band.
  using Decode = std::function<void(std::int64_t index, Band& band)>;

  BandCache(std::int64_t bands, std::int64_t kept, Decode decode);

  /// How many bands stay decoded. A range that is longer than that is held whole all the same.
  void keep(std::int64_t bands);
  std::int64_t kept() const;

  /// A range of bands that stays in memory as long as this object exists.
  class Pinned {
   public:
    Pinned(BandCache& cache, std::int64_t first, std::int64_t last);
    ~Pinned() { cache_.unpin(first_, last_); }
    Pinned(const Pinned&) = delete;
    Pinned& operator=(const Pinned&) = delete;
    const Band& operator[](std::int64_t index) const { return cache_.slots_[static_cast<std::size_t>(index)].band; }

   private:
    BandCache& cache_;
    std::int64_t first_, last_;
  };

 private:
  enum class State { empty, busy, ready };
  struct Slot {
    State state = State::empty;
    int readers = 0;
    Band band;
  };
  using Guard = std::unique_lock<std::mutex>;

  void pin(std::int64_t first, std::int64_t last);
  void unpin(std::int64_t first, std::int64_t last);
  void fetch(Guard& guard, std::int64_t first, std::int64_t last);
  void decode(Guard& guard, Slot& slot, std::int64_t index);
  void trim();
  Band reclaim();

  mutable std::mutex lock_;
  std::condition_variable changed_;
  std::vector<Slot> slots_;
  std::int64_t kept_, held_ = 0, pinned_ = 0;  // held: busy or ready; pinned: with readers
  Decode decode_;
};

}  // namespace mtf::io
