// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory of images. The first touch of a page of 4 KiB takes a quarter of a microsecond, on a virtual machine up to 15:
// as long as to filter the samples in it. Linux gives pages of 2 MiB, at a fraction of that, to those that ask for them
// (transparent_hugepage = madvise, or always); so large blocks ask.

#include <cstddef>

namespace mtf {

inline constexpr std::size_t kLargeBlock = std::size_t{4} << 20;  ///< bytes; from here on blocks ask for huge pages

/// Memory of `count` objects of `size` bytes, uninitialised and aligned to 64 bytes. The result is never null; throws
/// std::bad_alloc.
void* allocate(std::size_t count, std::size_t size);

/// Frees what allocate() gave; null is allowed. std::free does the same.
void release(void* block) noexcept;

}  // namespace mtf
