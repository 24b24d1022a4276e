// SPDX-License-Identifier: Apache-2.0

// The large blocks of everything in the command, readers of files and vectors among them, ask for huge pages as images
// do (mtf/memory.h): of an image of 5 megapixels reading takes half the time, of a 3-D scene three quarters. A
// sanitizer keeps its own operators.

#include <cstdlib>
#include <new>

#include "mtf/memory.h"

#ifndef __SANITIZE_ADDRESS__

void* operator new(std::size_t bytes) {
  if (bytes >= mtf::kLargeBlock) return mtf::allocate(1, bytes);
  if (void* const block = std::malloc(bytes == 0 ? 1 : bytes)) return block;
  throw std::bad_alloc();
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }

#endif
