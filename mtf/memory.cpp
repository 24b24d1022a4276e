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

/// Asks for pages of 2 MiB where they lie whole within the block: aligned to them there would be holes between blocks.
void ask_for_huge_pages(void* block, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t kHugePage = std::uintptr_t{2} << 20;
  const auto begin = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = (begin + kHugePage - 1) / kHugePage * kHugePage,
                       last = (begin + bytes) / kHugePage * kHugePage;
  // That the system has none to give is no error.
  if (last > first) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#else
  static_cast<void>(block), static_cast<void>(bytes);
#endif
}

}  // namespace

void* allocate(std::size_t count, std::size_t size) {
  if (size != 0 && count > PTRDIFF_MAX / size) throw std::bad_alloc();
  const std::size_t bytes = count * size;
  void* block = nullptr;
  if (::posix_memalign(&block, kAlignment, bytes == 0 ? 1 : bytes) != 0) throw std::bad_alloc();
  if (bytes >= kLargeBlock) ask_for_huge_pages(block, bytes);
  return block;
}

void release(void* block) noexcept { std::free(block); }

}  // namespace mtf
