// SPDX-License-Identifier: Apache-2.0

// The program `mtf`; the command itself is in the core library (main.cpp).
// Its vectors and strings ask for huge pages as images do (mtf/memory.h), where they are large: on a virtual machine
// `mtf simulate` reads an image of 5 megapixels in 0.30 s in place of 0.47, and the first picture of a 3-D scene takes
// three quarters of the time. Sanitizers keep their own operators.

#include <cstdlib>
#include <new>

#include "apps/commands.h"
#include "mtf/memory.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

void* operator new(std::size_t bytes) {
  if (bytes >= mtf::kLargeBlock) return mtf::allocate(1, bytes);
  if (void* const block = std::malloc(bytes == 0 ? 1 : bytes)) return block;
  throw std::bad_alloc();
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }

#endif

int main(int argc, char** argv) { return apps::run_command(argc, argv); }
