// SPDX-License-Identifier: Apache-2.0

// Stacks of frames of 2048 x 2048 pixels from memory to sums, by threads and frames at a time: GB/s of frames of 16
// bits (2 bytes a pixel, though the values lie there as floats). Beside them in the same run the floor, which is the
// time to read the frames and to add them up, and the plain loop of sum and sum of squares of each pixel, a frame at a
// time, on as many threads.

#include <algorithm>
#include <cstdio>
#include <functional>
#include <random>

#include "calib/characterize/stack_statistics.h"
#include "mtf/math/clones.h"
#include "mtf/parallel.h"
#include "mtf/version.h"
#include "tests/bench/interleave.h"

namespace {

constexpr std::int64_t kSide = 2048, kPixels = kSide * kSide, kFrames = 16;

MTFKIT_CLONES double total(const float* values, std::int64_t count) {
  double part[16]{};
  for (std::int64_t i = 0; i < count; i += 16)
    for (std::int64_t k = 0; k < 16; ++k) part[k] += static_cast<double>(values[i + k]);
  double sum = 0.0;
  for (const double p : part) sum += p;
  return sum;
}

MTFKIT_CLONES void add_plainly(const float* values, std::int64_t count, double* sum, double* squares) {
  for (std::int64_t i = 0; i < count; ++i) {
    const auto value = static_cast<double>(values[i]);
    sum[i] += value;
    squares[i] += value * value;
  }
}

}  // namespace

int main() {
  std::mt19937 engine(1);
  std::vector<mtf::Image> images;
  std::vector<mtf::ImageView<const float>> frames;
  for (std::int64_t t = 0; t < kFrames; ++t) {
    mtf::Image& image = images.emplace_back(kSide, kSide);
    for (std::int64_t i = 0; i < kPixels; ++i) image.data()[i] = static_cast<float>(1000 + (engine() & 255U));
    frames.push_back(image.view());
  }
  std::printf("mtfkit %s %s; GB/s of 16-bit frames, best and median\n", std::string(mtf::version).c_str(),
              std::string(mtf::git_commit).c_str());
  std::vector<double> sum(kPixels), squares(kPixels), parts(kSide);
  for (const int threads : {1, 2}) {
    const auto rows = [&](const std::function<void(std::int64_t)>& work) {
      mtf::parallel_for(kSide, 64, threads, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t y = begin; y < end; ++y) work(y);
      });
    };
    calib::StackStatistics stack(kSide, kSide, {.low = 0.0, .high = 65535.0});
    const auto statistics = [&](std::size_t at_a_time) {
      return [&, at_a_time] {
        for (std::size_t t = 0; t < frames.size(); t += at_a_time)
          stack.add(std::span(frames).subspan(t, at_a_time), threads);
      };
    };
    const auto timings = bench::interleave(
        {[&] {
           for (const auto& frame : frames)
             rows([&](std::int64_t y) { parts[static_cast<std::size_t>(y)] = total(frame.row(y), kSide); });
         },
         [&] {
           for (const auto& frame : frames)
             rows([&](std::int64_t y) {
               add_plainly(frame.row(y), kSide, sum.data() + y * kSide, squares.data() + y * kSide);
             });
         },
         statistics(1), statistics(2), statistics(8)},
        9);
    const char* const names[] = {"read and add up", "sum and squares of pixels", "StackStatistics, 1 frame at a time",
                                 "2 frames at a time", "8 frames at a time"};
    for (std::size_t k = 0; k < timings.size(); ++k)
      std::printf("%d threads  %-36s %6.2f %6.2f\n", threads, names[k], 2e-6 * kPixels * kFrames / timings[k].min_ms,
                  2e-6 * kPixels * kFrames / timings[k].median_ms);
  }
}
