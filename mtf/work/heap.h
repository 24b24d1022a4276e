// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the C library does with memory that is freed. Without rules it moves its own limits with the sizes that it
// meets: blocks of a few MiB then leave holes that later ones of other sizes do not fit, beyond any limit that was
// asked for.

#include <cstddef>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace mtf {

struct HeapRules {
  std::size_t returned_from = 0;  ///< bytes: blocks of that size and more go back to the system when they are freed
  std::size_t kept_at_end = std::size_t{128} << 10;  ///< free bytes at the end of the heap that stay for later blocks
  bool one_for_all_threads = false;                  ///< only before there are threads
};

/// Of the whole process, from now on. Other C libraries than glibc have no such rules.
inline void set_heap([[maybe_unused]] const HeapRules& rules) {
#ifdef __GLIBC__
  if (rules.one_for_all_threads) ::mallopt(M_ARENA_MAX, 1);
  ::mallopt(M_MMAP_THRESHOLD, static_cast<int>(rules.returned_from));
  ::mallopt(M_TRIM_THRESHOLD, static_cast<int>(rules.kept_at_end));
#endif
}

}  // namespace mtf
