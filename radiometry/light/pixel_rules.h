// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixels that an input may not have, found before anything is changed: how many there are, and the first one.

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <string>

#include "mtf/error.h"
#include "mtf/image.h"
#include "mtf/parallel.h"
#include "mtf/units.h"

namespace radiometry {

/// Rows of one piece of work for a thread.
inline constexpr std::int64_t kRowsAtOnce = 16;

/// The parts of a message: "<what>: 3 pixels <wrong>, the first at column 7, row 2 (-0.5); <remedy>".
struct PixelRule {
  std::string what, wrong, remedy;
};

/// Throws UsageError when there are pixels for which bad(value). The same for any number of threads.
template <class Bad>
void refuse_pixels(mtf::ImageView<const float> plane, const PixelRule& rule, int threads, Bad bad) {
  std::mutex joining;
  std::int64_t count = 0, first = plane.width * plane.height;
  mtf::parallel_for_each(plane.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    const float* row = plane.row(y);
    std::int64_t here = 0;
    for (std::int64_t x = 0; x < plane.width; ++x) here += bad(row[x]) ? 1 : 0;
    if (here == 0) return;
    const std::int64_t x = std::find_if(row, row + plane.width, bad) - row;
    const std::lock_guard lock(joining);
    count += here;
    first = std::min(first, y * plane.width + x);
  });
  if (count == 0) return;
  const std::int64_t x = first % plane.width, y = first / plane.width;
  throw mtf::UsageError(rule.what + ": " + std::to_string(count) + (count == 1 ? " pixel " : " pixels ") + rule.wrong +
                        ", the first at column " + std::to_string(x) + ", row " + std::to_string(y) + " (" +
                        mtf::format_double(static_cast<double>(plane.at(x, y))) + "); " + rule.remedy);
}

/// Throws UsageError for a plane beside the scene that is of another size.
inline void require_size_of(mtf::ImageView<const float> scene, mtf::ImageView<const float> plane,
                            const std::string& what) {
  if (plane.width == scene.width && plane.height == scene.height) return;
  throw mtf::UsageError(what + ": " + std::to_string(plane.width) + " x " + std::to_string(plane.height) +
                        " pixels beside a scene of " + std::to_string(scene.width) + " x " +
                        std::to_string(scene.height) + "; give one of its size");
}

/// Replaces each pixel by change(pixel), rows on `threads` threads.
template <class Change>
void for_each_pixel(mtf::ImageView<float> plane, int threads, Change change) {
  mtf::parallel_for_each(plane.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    float* row = plane.row(y);
    for (std::int64_t x = 0; x < plane.width; ++x) row[x] = change(row[x]);
  });
}

/// The same with the pixel of another plane of that size.
template <class Change>
void for_each_pixel(mtf::ImageView<float> plane, mtf::ImageView<const float> other, int threads, Change change) {
  mtf::parallel_for_each(plane.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    float* row = plane.row(y);
    const float* beside = other.row(y);
    for (std::int64_t x = 0; x < plane.width; ++x) row[x] = change(row[x], beside[x]);
  });
}

}  // namespace radiometry
