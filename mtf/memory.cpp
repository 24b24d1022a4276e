// SPDX-License-Identifier: Apache-2.0
#include "mtf/memory.h"

#include <cstdint>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace mtf {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kHugePage = std::size_t{2} << 20;

}  // namespace

void* allocate(std::size_t count, std::size_t size) {
  if (size != 0 && count > (PTRDIFF_MAX - kHugePage) / size) throw std::bad_alloc();
  const std::size_t bytes = count * size;
  const bool large = bytes >= kLargeBlock;
  const std::size_t alignment = large ? kHugePage : kAlignment;
  // std::aligned_alloc wants a multiple of the alignment; what is not touched costs address space alone.
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* const block = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (block == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  // Whole pages of the block alone. That the system has none to give is no error.
  if (large) ::madvise(block, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
  return block;
}

void release(void* block) noexcept { std::free(block); }

}  // namespace mtf
