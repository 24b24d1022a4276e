// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory that one run gives back and the next takes again: fresh pages cost more than the work on them.

#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "mtf/image.h"

namespace mtf {

class BufferPool {
 public:
  /// A buffer on loan, uninitialised; the pool has to outlive it.
  template <class T>
  class Loan {
   public:
    Loan(BufferPool& pool, std::size_t count) : pool_(&pool), buffer_(pool.take(count * sizeof(T))) {}
    Loan(Loan&& other) noexcept : pool_(std::exchange(other.pool_, nullptr)), buffer_(std::move(other.buffer_)) {}
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (pool_ != nullptr) pool_->give(std::move(buffer_));
    }
    T* data() const { return reinterpret_cast<T*>(buffer_.data()); }

   private:
    BufferPool* pool_;
    AlignedBuffer<std::byte> buffer_;
  };

 private:
  static constexpr std::size_t kMostKept = std::size_t{256} << 20, kMostBuffers = 64;

  AlignedBuffer<std::byte> take(std::size_t bytes) {
    {
      const std::scoped_lock guard(lock_);
      for (std::size_t i = free_.size(); i-- > 0;)
        if (free_[i].size() == bytes) {
          AlignedBuffer<std::byte> buffer = std::move(free_[i]);
          free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(i));
          kept_ -= bytes;
          return buffer;
        }
    }
    return AlignedBuffer<std::byte>(bytes);
  }

  void give(AlignedBuffer<std::byte> buffer) noexcept {
    const std::scoped_lock guard(lock_);
    if (free_.size() >= kMostBuffers || kept_ + buffer.size() > kMostKept) return;
    kept_ += buffer.size();
    free_.push_back(std::move(buffer));  // there is room for kMostBuffers
  }

  std::mutex lock_;
  std::size_t kept_ = 0;
  std::vector<AlignedBuffer<std::byte>> free_ = [] {
    std::vector<AlignedBuffer<std::byte>> list;
    list.reserve(kMostBuffers);
    return list;
  }();
};

}  // namespace mtf
