// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_image.h"

#include <algorithm>
#include <array>
#include <bit>

#include "mtf/device/device_parts.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace mtf {
namespace {

using Place = Device::Parts::Place;
using Arguments = std::vector<KernelArgument>;

/// Held pixels at the well, at the least and at the largest count, and those that are no numbers.
constexpr std::size_t kCounts = 4;
using Counts = std::array<std::uint32_t, kCounts>;

constexpr std::size_t kKeys = 1 << 16;  // halves of 32 bits

/// The bin of a rank, which then counts from the bin's first on.
std::uint32_t bin_of(std::int64_t& rank, std::span<const std::uint32_t> counts) {
  std::size_t bin = 0;
  while (bin + 1 < counts.size() && rank >= std::int64_t{counts[bin]}) rank -= std::int64_t{counts[bin++]};
  return static_cast<std::uint32_t>(bin);
}

/// Numbers of the host for the kernel that comes next.
const DeviceMemory& sent(Device::Parts& parts, std::span<const float> numbers) {
  const DeviceMemory& memory = parts.memory(Place::numbers, numbers.size_bytes());
  parts.backend->upload(parts.queue, numbers.data(), memory, numbers.size_bytes());
  parts.backend->finish(parts.queue);  // before the caller's numbers go
  return memory;
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

const DeviceMemory& DeviceImage::pixels_of(Device::Parts& parts) const {
  return parts.memory(frames_ > 1 ? Place::frames : Place::image,
                      static_cast<std::size_t>(frames_ * width_ * height_) * sizeof(float));
}

const DeviceMemory& DeviceImage::counts_of(Device::Parts& parts) const {
  return parts.memory(Place::counts, static_cast<std::size_t>(frames_) * sizeof(Counts));
}

void DeviceImage::clear(Device::Parts& parts, const DeviceMemory& counts, std::size_t count) const {
  parts.backend->launch(parts.queue, "clear", {static_cast<std::int64_t>(count), 1, 1},
                        std::array<KernelArgument, 2>{counts, static_cast<std::int32_t>(count)});
}

/// The numbers with which a kernel finds its random words.
void DeviceImage::add_random(Arguments& arguments, const DeviceRandom& random) const {
  for (const std::uint32_t number :
       {random.x, random.y, random.frame, step_, random.stream, static_cast<std::uint32_t>(random.seed),
        static_cast<std::uint32_t>(random.seed >> 32)})
    arguments.emplace_back(number);
}

template <class Append>
void DeviceImage::launch(const char* kernel, std::int64_t columns, std::int64_t frames, const Append& append) {
  on_device([&](Device::Parts& parts) {
    if (parts.fault == DeviceFault::chain) throw DeviceError("a fault after the filter that was asked for");
    Arguments arguments{pixels_of(parts), static_cast<std::int32_t>(width_), static_cast<std::int32_t>(height_)};
    append(parts, arguments);
    parts.backend->launch(parts.queue, kernel, {columns, height_, frames}, arguments);
  });
}

template <class Append>
void DeviceImage::run(const char* kernel, std::int64_t columns, const Append& append) {
  launch(kernel, columns, frames_, append);
  values_ = Values::floats;
}

template <class Append>
void DeviceImage::run_chosen(const char* kernel, const Append& append) {
  launch(kernel, width_, 1, append);
  values_ = Values::floats;
}

DeviceImage::DeviceImage(std::shared_ptr<const Device> device, std::int64_t width, std::int64_t height,
                         std::unique_lock<std::mutex> held)
    : device_(std::move(device)), width_(width), height_(height), held_(std::move(held)) {
  on_device([&](Device::Parts& parts) { clear(parts, counts_of(parts), kCounts); });
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

void DeviceImage::repeat(std::int64_t frames, std::uint32_t step) {
  if (frames_ != 1) throw UsageError("a batch of frames is made of one image, not of another batch");
  frames_ = frames;
  step_ = step;
  if (frames == 1) return;
  run("repeat", width_, [&](Device::Parts& parts, Arguments& arguments) {
    clear(parts, counts_of(parts), kCounts * static_cast<std::size_t>(frames));
    arguments.emplace_back(parts.memory(Place::image, static_cast<std::size_t>(width_ * height_) * sizeof(float)));
  });
}

bool DeviceImage::has_room(const DeviceInfo& info, std::int64_t width, std::int64_t height, std::int64_t frames) {
  constexpr std::int64_t kShare = 4;  // of the memory, for pixels and whole numbers; filters and maps take theirs
  const std::int64_t pixels = width * height * frames;
  return 4 * pixels <= info.largest_bytes && 6 * pixels <= info.bytes / kShare;
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
  const std::int64_t lines = of_rows ? height_ : width_;
  if (std::ssize(numbers) != lines && std::ssize(numbers) != lines * frames_)
    throw UsageError(std::to_string(numbers.size()) + " numbers for the lines of an image of " +
                     size_text(width_, height_));
  run("add_lines", width_, [&](Device::Parts& parts, Arguments& arguments) {
    arguments.emplace_back(sent(parts, numbers));
    arguments.emplace_back(std::int32_t{of_rows});
    arguments.emplace_back(static_cast<std::int32_t>(std::ssize(numbers) == lines ? 0 : lines));
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
  if (most <= 65535.0) values_ = most <= 255.0 ? Values::bytes : Values::words;
}

template <class Append>
std::vector<std::uint32_t> DeviceImage::counted(const char* kernel, std::size_t bins, const Append& append) {
  std::vector<std::uint32_t> counts(bins);
  run_chosen(kernel, [&](Device::Parts& parts, Arguments& arguments) {
    const DeviceMemory& memory = parts.memory(Place::bins, bins * sizeof counts[0]);
    clear(parts, memory, bins);
    arguments.emplace_back(memory);
    arguments.emplace_back(chosen_);
    append(arguments);
  });
  on_device([&](Device::Parts& parts) {
    const std::size_t bytes = counts.size() * sizeof counts[0];
    parts.backend->download(parts.queue, parts.memory(Place::bins, bytes), counts.data(), bytes);
    parts.backend->finish(parts.queue);
  });
  return counts;
}

std::vector<std::uint32_t> DeviceImage::order() {
  return counted("count_keys", kKeys, [](Arguments& arguments) {
    arguments.emplace_back(std::int32_t{16});
    arguments.emplace_back(std::uint32_t{0});
  });
}

float DeviceImage::value_at(std::int64_t rank, std::span<const std::uint32_t> order) {
  const std::uint32_t upper = bin_of(rank, order);
  const std::vector<std::uint32_t> lower = counted("count_keys", kKeys, [&](Arguments& arguments) {
    arguments.emplace_back(std::int32_t{0});
    arguments.emplace_back(upper);
  });
  const std::uint32_t key = upper << 16 | bin_of(rank, lower), sign = 0x80000000U;
  return std::bit_cast<float>((key & sign) != 0 ? key ^ sign : ~key);
}

std::vector<std::uint32_t> DeviceImage::histogram(double low, double scale, std::int64_t bins) {
  return counted("count_bins", static_cast<std::size_t>(bins), [&](Arguments& arguments) {
    arguments.emplace_back(low);
    arguments.emplace_back(scale);
    arguments.emplace_back(static_cast<std::int32_t>(bins));
  });
}

void DeviceImage::tone(std::span<const float> levels, double low, double scale) {
  run_chosen("tone", [&](Device::Parts& parts, Arguments& arguments) {
    arguments.emplace_back(sent(parts, levels));
    arguments.emplace_back(chosen_);
    arguments.emplace_back(static_cast<std::int32_t>(levels.size() - 1));
    arguments.emplace_back(low);
    arguments.emplace_back(scale);
  });
}

void DeviceImage::round_to_bytes() { values_ = Values::bytes; }

DeviceImage::Held DeviceImage::download(ImageView<float> out, int threads) {
  return download(std::span(&out, 1), threads).front();
}

std::vector<DeviceImage::Held> DeviceImage::download(std::span<const ImageView<float>> out, int threads) {
  if (std::ssize(out) != frames_)
    throw UsageError(std::to_string(out.size()) + " images for a batch of " + std::to_string(frames_) + " frames");
  const auto pixels = static_cast<std::size_t>(frames_ * width_ * height_);
  std::vector<Counts> counts(out.size());
  const auto fetch = [&]<class T>(Place place, T) {
    const PinnedMemory* fetched = nullptr;
    on_device([&](Device::Parts& parts) {
      const std::size_t bytes = pixels * sizeof(T);
      fetched = &parts.pinned(1, bytes);
      parts.backend->download(parts.queue, parts.memory(place, bytes), fetched->data, bytes);
      parts.backend->download(parts.queue, counts_of(parts), counts.data(), counts.size() * sizeof(Counts));
      parts.backend->finish(parts.queue);
    });
    const T* const from = static_cast<const T*>(fetched->data);
    parallel_for_each(frames_ * height_, 64, threads, [&](std::int64_t y) {
      std::copy_n(from + y * width_, width_, out[static_cast<std::size_t>(y / height_)].row(y % height_));
    });
  };
  const auto fetch_whole = [&]<class T>(const char* kernel, T number) {
    run(kernel, width_, [&](Device::Parts& parts, Arguments& arguments) {
      arguments.emplace_back(parts.memory(Place::whole, pixels * sizeof number));
      arguments.emplace_back(counts_of(parts));
    });
    fetch(Place::whole, number);
  };
  const Values values = values_;
  if (values == Values::bytes) fetch_whole("whole_bytes", std::uint8_t{});
  if (values == Values::words) fetch_whole("whole_words", std::uint16_t{});
  const auto has_none = [](const Counts& of_frame) { return of_frame[3] > 0; };
  if (values == Values::floats || std::ranges::any_of(counts, has_none))
    fetch(frames_ > 1 ? Place::frames : Place::image, float{});
  std::vector<Held> held;
  for (const Counts& of_frame : counts) held.push_back({of_frame[0], of_frame[1], of_frame[2]});
  return held;
}

}  // namespace mtf
