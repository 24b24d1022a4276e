// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_image.h"

#include <algorithm>
#include <array>

#include "mtf/device/device_parts.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace mtf {
namespace {

using Place = Device::Parts::Place;
using Arguments = std::vector<KernelArgument>;

/// Held pixels at the well, at the least and at the largest count.
using Counts = std::array<std::uint32_t, 3>;
constexpr Counts kNone{};

const DeviceMemory& counts_of(Device::Parts& parts) { return parts.memory(Place::counts, sizeof kNone); }

/// The numbers with which a kernel finds its random words.
void add_random(Arguments& arguments, const DeviceRandom& random) {
  for (const std::uint32_t number :
       {random.x, random.y, random.frame, random.stream, static_cast<std::uint32_t>(random.seed),
        static_cast<std::uint32_t>(random.seed >> 32)})
    arguments.emplace_back(number);
}

}  // namespace

template <class Work>
void DeviceImage::on_device(const Work& work) {
  Device::Parts& parts = device_->parts();
  try {
    work(parts);
  } catch (const DeviceError& error) {
    parts.fail(error);
  }
}

template <class Append>
void DeviceImage::run(const char* kernel, std::int64_t columns, const Append& append) {
  on_device([&](Device::Parts& parts) {
    if (parts.fault == DeviceFault::chain) throw DeviceError("a fault after the filter that was asked for");
    const DeviceMemory& image = parts.memory(Place::image, static_cast<std::size_t>(width_ * height_) * sizeof(float));
    Arguments arguments{image, static_cast<std::int32_t>(width_), static_cast<std::int32_t>(height_)};
    append(parts, arguments);
    parts.backend->launch(parts.queue, kernel, {columns, height_, 1}, arguments);
  });
}

DeviceImage::DeviceImage(std::shared_ptr<const Device> device, std::int64_t width, std::int64_t height,
                         std::unique_lock<std::mutex> held)
    : device_(std::move(device)), width_(width), height_(height), held_(std::move(held)) {
  on_device(
      [&](Device::Parts& parts) { parts.backend->upload(parts.queue, kNone.data(), counts_of(parts), sizeof kNone); });
}

DeviceImage::~DeviceImage() {
  try {
    device_->parts().backend->finish(device_->parts().queue);  // memory of the host may be in use until then
  } catch (const DeviceError&) {                               // whoever runs next hears of it
  }
}

const DeviceMemory& DeviceImage::map_of(Device::Parts& parts, const std::shared_ptr<const Image>& map) const {
  if (map->width() != width_ || map->height() != height_)
    throw UsageError("a map of " + size_text(map->width(), map->height()) + " pixels for an image of " +
                     size_text(width_, height_));
  return parts.map(map);
}

void DeviceImage::multiply_add(const DeviceLinear& gain, const DeviceLinear& offset) {
  run("multiply_add", width_, [&](Device::Parts& parts, Arguments& arguments) {
    const KernelArgument image = arguments.front();  // in place of a map, which is then not read
    for (const DeviceLinear* one : {&gain, &offset}) {
      arguments.push_back(one->map ? KernelArgument(map_of(parts, one->map)) : image);
      arguments.emplace_back(std::int32_t{one->map != nullptr});
      arguments.emplace_back(one->number);
      arguments.emplace_back(one->added);
    }
  });
}

void DeviceImage::add(const std::shared_ptr<const Image>& map) {
  run("add_map", width_,
      [&](Device::Parts& parts, Arguments& arguments) { arguments.emplace_back(map_of(parts, map)); });
}

void DeviceImage::add_lines(std::span<const float> numbers, bool of_rows) {
  if (static_cast<std::int64_t>(numbers.size()) != (of_rows ? height_ : width_))
    throw UsageError(std::to_string(numbers.size()) + " numbers for the lines of an image of " +
                     size_text(width_, height_));
  run("add_lines", width_, [&](Device::Parts& parts, Arguments& arguments) {
    const DeviceMemory& lines =
        parts.memory(Place::lines, static_cast<std::size_t>(std::max(width_, height_)) * sizeof(float));
    parts.backend->upload(parts.queue, numbers.data(), lines, numbers.size_bytes());
    parts.backend->finish(parts.queue);  // before the caller's numbers go
    arguments.emplace_back(lines);
    arguments.emplace_back(std::int32_t{of_rows});
  });
}

void DeviceImage::add_gaussian(float sigma, const DeviceRandom& random) {
  run("add_gaussian", pairs(random), [&](Device::Parts&, Arguments& arguments) {
    arguments.emplace_back(sigma);
    add_random(arguments, random);
  });
}

void DeviceImage::shot_noise(const DeviceRandom& random) {
  run("shot_noise", pairs(random), [&](Device::Parts&, Arguments& arguments) { add_random(arguments, random); });
}

void DeviceImage::hold_well(float well) {
  run("hold_well", width_, [&](Device::Parts& parts, Arguments& arguments) {
    arguments.emplace_back(counts_of(parts));
    arguments.emplace_back(well);
  });
}

void DeviceImage::bend(double well, double a2, double a3, double a4) {
  run("bend", width_, [&](Device::Parts&, Arguments& arguments) {
    for (const double number : {well, a2, a3, a4}) arguments.emplace_back(number);
  });
}

void DeviceImage::digitise(double scale, double offset, double most) {
  run("digitise", width_, [&](Device::Parts& parts, Arguments& arguments) {
    arguments.emplace_back(counts_of(parts));
    for (const double number : {scale, offset, most}) arguments.emplace_back(number);
  });
}

DeviceImage::Held DeviceImage::download(ImageView<float> out, int threads) {
  Counts counts{};
  const PinnedMemory* pixels = nullptr;
  on_device([&](Device::Parts& parts) {
    const std::size_t bytes = static_cast<std::size_t>(width_ * height_) * sizeof(float);
    pixels = &parts.pinned(1, bytes);
    parts.backend->download(parts.queue, parts.memory(Place::image, bytes), pixels->data, bytes);
    parts.backend->download(parts.queue, counts_of(parts), counts.data(), sizeof counts);
    parts.backend->finish(parts.queue);
  });
  parallel_for_each(height_, 64, threads,
                    [&](std::int64_t y) { std::copy_n(pixels->floats() + y * width_, width_, out.row(y)); });
  return {counts[0], counts[1], counts[2]};
}

}  // namespace mtf
