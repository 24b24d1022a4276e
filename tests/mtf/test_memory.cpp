// SPDX-License-Identifier: Apache-2.0
// Memory of images: where blocks lie, and sizes that there cannot be.

#include "mtf/memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <new>

#include "mtf/image.h"

namespace mtf {
namespace {

TEST(Memory, BlocksAreAlignedAndWhole) {
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{65}, kLargeBlock - 1, kLargeBlock,
                                  kLargeBlock + 12345, std::size_t{40} << 20}) {
    void* const block = allocate(bytes, 1);
    ASSERT_NE(block, nullptr);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % 64, 0u) << bytes;
    std::memset(block, 7, bytes);
    release(block);
  }
  release(nullptr);
}

TEST(Memory, RefusesSizesThatOverflow) {
  EXPECT_THROW(allocate(SIZE_MAX, 1), std::bad_alloc);
  EXPECT_THROW(allocate(SIZE_MAX / 4 + 2, 4), std::bad_alloc);  // 4 bytes, if it wrapped
  EXPECT_THROW(AlignedBuffer<double>(SIZE_MAX / 8 + 2), std::bad_alloc);
  EXPECT_THROW(Image(-1, 1), std::bad_alloc);
}

}  // namespace
}  // namespace mtf
