// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "mtf/memory.h"

namespace mtf {

/// A rectangle of samples or pixels.
struct Region {
  std::int64_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Region&) const = default;
};

/// A non-owning, row-major view of one image plane. `stride` counts elements from one row to the next, stride >= width.
template <class T>
struct ImageView {
  T* data = nullptr;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t stride = 0;

  T* row(std::int64_t y) const { return data + y * stride; }
  T& at(std::int64_t x, std::int64_t y) const { return data[y * stride + x]; }
  operator ImageView<const T>() const {
    return {data, width, height, stride};
  }  // NOLINT: a view of const is always safe
};

/// Memory aligned for SIMD, uninitialised, movable only. The allocation throws std::bad_alloc, never returns null.
template <class T>
class AlignedBuffer {
 public:
  AlignedBuffer() = default;
  explicit AlignedBuffer(std::size_t count) : data_(static_cast<T*>(allocate(count, sizeof(T)))), size_(count) {}

  T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* p) const { release(p); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

/// One owned float32 plane: row-major, linear values, rows packed without padding. Movable only; copy with `clone()`.
class Image {
 public:
  Image() = default;
  Image(std::int64_t width, std::int64_t height)
      : buffer_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)), width_(width), height_(height) {}

  std::int64_t width() const { return width_; }
  std::int64_t height() const { return height_; }
  std::int64_t size() const { return width_ * height_; }
  float* data() { return buffer_.data(); }
  const float* data() const { return buffer_.data(); }
  ImageView<float> view() { return {buffer_.data(), width_, height_, width_}; }
  ImageView<const float> view() const { return {buffer_.data(), width_, height_, width_}; }
  float& at(std::int64_t x, std::int64_t y) { return buffer_.data()[y * width_ + x]; }
  float at(std::int64_t x, std::int64_t y) const { return buffer_.data()[y * width_ + x]; }
  /// Takes another size, no larger in samples, in the memory there is; the samples are as they lie there.
  void reshape(std::int64_t width, std::int64_t height) {
    assert(width * height <= static_cast<std::int64_t>(buffer_.size()));
    width_ = width;
    height_ = height;
  }
  Image clone() const {
    Image copy(width_, height_);
    for (std::int64_t i = 0; i < size(); ++i) copy.data()[i] = data()[i];
    return copy;
  }

 private:
  AlignedBuffer<float> buffer_;
  std::int64_t width_ = 0;
  std::int64_t height_ = 0;
};

/// The samples of a plane in that region of it.
template <class T>
ImageView<T> part_of(ImageView<T> plane, const Region& region) {
  return {plane.row(region.y) + region.x, region.width, region.height, plane.stride};
}

/// Into a plane of the same size.
inline void copy(ImageView<const float> from, ImageView<float> to) {
  for (std::int64_t y = 0; y < from.height; ++y)
    std::memcpy(to.row(y), from.row(y), static_cast<std::size_t>(from.width) * sizeof(float));
}

inline Image copy_of(ImageView<const float> plane) {
  Image image(plane.width, plane.height);
  copy(plane, image.view());
  return image;
}

}  // namespace mtf
