// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/exr/band_cache.h"

#include <algorithm>
#include <span>
#include <utility>

namespace mtf::io {

BandCache::BandCache(std::int64_t bands, std::int64_t kept, Decode decode)
    : slots_(static_cast<std::size_t>(bands)), kept_(kept), decode_(std::move(decode)) {}

void BandCache::keep(std::int64_t bands) {
  const Guard guard(lock_);
  kept_ = bands;
  trim();
}

void BandCache::trim() {
  while (held_ > kept_ && !reclaim().empty()) --held_;
}

std::int64_t BandCache::kept() const {
  const Guard guard(lock_);
  return kept_;
}

BandCache::Pinned::Pinned(BandCache& cache, std::int64_t first, std::int64_t last)
    : cache_(cache), first_(first), last_(last) {
  cache_.pin(first, last);
}

void BandCache::pin(std::int64_t first, std::int64_t last) {
  Guard guard(lock_);
  const std::span<Slot> range(slots_.data() + first, static_cast<std::size_t>(last - first + 1));
  // A reader that holds a range never waits for memory, so that there is no deadlock.
  changed_.wait(guard, [&] {
    const auto more = std::count_if(range.begin(), range.end(), [](const Slot& slot) { return slot.readers == 0; });
    return pinned_ == 0 || pinned_ + more <= kept_;
  });
  for (Slot& slot : range) pinned_ += slot.readers++ == 0 ? 1 : 0;
  try {
    fetch(guard, first, last);
  } catch (...) {
    guard.unlock();
    unpin(first, last);
    throw;
  }
}

void BandCache::unpin(std::int64_t first, std::int64_t last) {
  {
    const Guard guard(lock_);
    for (std::int64_t i = first; i <= last; ++i) pinned_ -= --slots_[static_cast<std::size_t>(i)].readers == 0 ? 1 : 0;
    trim();
  }
  changed_.notify_all();
}

// Decodes what nobody has begun, then waits for the rest; what another thread failed at is tried again here.
void BandCache::fetch(Guard& guard, std::int64_t first, std::int64_t last) {
  for (;;) {
    bool ready = true, locked_all_along = true;
    for (std::int64_t i = first; i <= last; ++i) {
      Slot& slot = slots_[static_cast<std::size_t>(i)];
      if (slot.state == State::empty) {
        decode(guard, slot, i);
        locked_all_along = false;
      }
      ready = ready && slot.state == State::ready;
    }
    if (ready) return;
    if (locked_all_along) changed_.wait(guard);
  }
}

void BandCache::decode(Guard& guard, Slot& slot, std::int64_t index) {
  slot.state = State::busy;
  if (held_ >= kept_) slot.band = reclaim();
  if (slot.band.empty()) ++held_;
  guard.unlock();
  try {
    decode_(index, slot.band);
  } catch (...) {
    guard.lock();
    slot.band.clear();
    slot.state = State::empty;
    --held_;
    changed_.notify_all();
    throw;
  }
  guard.lock();
  slot.state = State::ready;
  changed_.notify_all();
}

// The memory of the topmost band that nobody reads; nothing where all are read.
Band BandCache::reclaim() {
  const auto spare = std::find_if(slots_.begin(), slots_.end(),
                                  [](const Slot& slot) { return slot.state == State::ready && slot.readers == 0; });
  if (spare == slots_.end()) return {};
  spare->state = State::empty;
  return std::exchange(spare->band, {});
}

}  // namespace mtf::io
