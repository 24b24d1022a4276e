// SPDX-License-Identifier: Apache-2.0
#pragma once

// An image that stays on the device that has filtered it (Plan::run_on_device), while a chain of a sensor changes its
// pixels there, so that it crosses to the host once and not after each stage. Each operation is that of the processor
// with its roundings in its order, on the same random words (mtf/device/pixels.cl), so that the numbers
// are the processor's to the bit.
//
// The image holds its device: others wait until it is gone. Operations throw DeviceError.

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "mtf/device/device.h"
#include "mtf/image.h"

namespace mtf {

/// The random numbers of one purpose, from the first pixel of the image on (radiometry/stages/noise/random.h).
struct DeviceRandom {
  std::uint64_t seed = 0;
  std::uint32_t frame = 0, stream = 0;
  std::uint32_t x = 0, y = 0;  ///< of that pixel on the detector
};

/// number x map + added at each pixel, as the processor's chain has it; 1 where there is no map.
struct DeviceLinear {
  std::shared_ptr<const Image> map{};
  float number = 1.0F, added = 0.0F;
};

class DeviceImage {
 public:
  /// What a filter has left (mtf/device/device_filter.h), with the lock of its device.
  DeviceImage(std::shared_ptr<const Device> device, std::int64_t width, std::int64_t height,
              std::unique_lock<std::mutex> held);
  DeviceImage(const DeviceImage&) = delete;
  DeviceImage& operator=(const DeviceImage&) = delete;
  ~DeviceImage();

  /// Makes a batch of it: so many frames, each from this image on, with the random numbers of frames that are `step`
  /// apart. All that is done is done to all of them, in one submission each.
  void repeat(std::int64_t frames, std::uint32_t step);
  std::int64_t frames() const { return frames_; }
  std::uint32_t step() const { return step_; }
  /// The one that order(), value_at(), histogram() and tone() are for.
  void choose(std::int64_t frame) { chosen_ = static_cast<std::int32_t>(frame); }
  /// Whether the device has room for such a batch beside what it holds.
  static bool has_room(const DeviceInfo& info, std::int64_t width, std::int64_t height, std::int64_t frames);

  /// image = gain x image + offset. Maps are sent once for as long as they are there.
  void multiply_add(const DeviceLinear& gain, const DeviceLinear& offset);
  void add(const std::shared_ptr<const Image>& map);
  /// A number for each row (`of_rows`), or for each column: one list for all frames, or one after another.
  void add_lines(std::span<const float> numbers, bool of_rows);
  void add_gaussian(float sigma, const DeviceRandom& random);
  /// Poisson numbers of these means.
  void shot_noise(const DeviceRandom& random);
  /// Values above `well` become it.
  void hold_well(float well);
  /// radiometry::Nonlinearity
  void bend(double well, double a2, double a3, double a4);
  /// floor(value x scale + offset), held between 0 and `most`, which is whole.
  void digitise(double scale, double offset, double most);

  /// How many finite pixels there are of each upper half of a key that rises with their value.
  std::vector<std::uint32_t> order();
  /// The value at a rank of the sorted finite pixels, of which order() was asked last.
  float value_at(std::int64_t rank, std::span<const std::uint32_t> order);
  /// How many pixels have (value - low) x scale in each of so many intervals of 1 from 0 on, the end in the last.
  std::vector<std::uint32_t> histogram(double low, double scale, std::int64_t bins);
  /// The curve through levels that lie 1 / scale apart from `low` on: straight between them, constant beyond.
  void tone(std::span<const float> levels, double low, double scale);
  /// Whole numbers are enough of values from 0 to 255: the image comes back rounded, halves upwards.
  void round_to_bytes();

  /// Pixels that were held so far.
  struct Held {
    std::int64_t well = 0, least = 0, most = 0;
  };
  /// Brings the image to the host, as 8 or 16 bits a pixel where these hold what the last operation has left.
  Held download(ImageView<float> out, int threads);
  /// The same of all frames.
  std::vector<Held> download(std::span<const ImageView<float>> out, int threads);

 private:
  /// Runs work(parts); notes a failure.
  template <class Work>
  void on_device(const Work& work);
  /// A kernel on a grid of `columns` threads for each row of each frame; append(parts, arguments) follow image, width
  /// and height.
  template <class Append>
  void run(const char* kernel, std::int64_t columns, const Append& append);
  /// The same for the one that is chosen; append(parts, arguments) give a memory, the frame and more.
  template <class Append>
  void run_chosen(const char* kernel, const Append& append);
  template <class Append>
  void launch(const char* kernel, std::int64_t columns, std::int64_t frames, const Append& append);
  const struct DeviceMemory& pixels_of(Device::Parts& parts) const;
  const DeviceMemory& counts_of(Device::Parts& parts) const;
  void clear(Device::Parts& parts, const DeviceMemory& counts, std::size_t count) const;
  void add_random(std::vector<class KernelArgument>& arguments, const DeviceRandom& random) const;
  /// The map on the device. Throws UsageError for one of another size.
  const DeviceMemory& map_of(Device::Parts& parts, const std::shared_ptr<const Image>& map) const;
  /// Threads of a row, each of which makes the two pixels that share random words.
  std::int64_t pairs(const DeviceRandom& random) const { return (width_ + random.x % 2 + 1) / 2; }

  /// What a kernel that counts pixels counts in each of so many bins.
  template <class Append>
  std::vector<std::uint32_t> counted(const char* kernel, std::size_t bins, const Append& append);

  std::shared_ptr<const Device> device_;
  std::int64_t width_, height_, frames_ = 1;
  std::uint32_t step_ = 0;
  std::int32_t chosen_ = 0;
  enum class Values { floats, words, bytes } values_ = Values::floats;  ///< that the pixels are: whole ones, or any
  std::unique_lock<std::mutex> held_;
};

}  // namespace mtf
