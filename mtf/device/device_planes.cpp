// SPDX-License-Identifier: Apache-2.0
#include "mtf/device/device_planes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "mtf/device/device_image.h"
#include "mtf/engines/kept_plane.h"
#include "mtf/engines/kernels.h"
#include "mtf/parallel.h"
#include "mtf/units.h"

namespace mtf {
namespace {

std::size_t bytes_of(const std::array<std::int64_t, 2>& size) {
  return static_cast<std::size_t>(size[0] * size[1]) * sizeof(float);
}

/// Whether differences or products may leave the range of float, or be so small that a device takes them for 0. The
/// host then scales the plane.
bool is_extreme(const Channel& channel) { return std::abs(std::ilogb(channel.scale)) > 100; }

bool stays(const Channel& channel) { return channel.stays != nullptr && !is_extreme(channel); }

}  // namespace

std::string memory_obstacle(const DeviceInfo& info, std::int64_t largest, std::int64_t needed) {
  const std::int64_t room = info.bytes / 10 * 9;
  if (largest <= info.largest_bytes && needed <= room) return "";
  return "it needs " + format_double(static_cast<double>(needed)) + " bytes on the device, " +
         format_double(static_cast<double>(largest)) + " of them in one piece; the device gives " +
         format_double(static_cast<double>(room)) + " and " + format_double(static_cast<double>(info.largest_bytes));
}

double transfers_ms(const DeviceTest& test, std::int64_t samples, std::int64_t outputs) {
  return test.transfer_ms +
         1e-6 * sizeof(float) *
             (test.upload_ns * static_cast<double>(samples) + test.download_ns * static_cast<double>(outputs));
}

DevicePlanes::DevicePlanes(std::shared_ptr<const Device> device, const std::array<std::int64_t, 2>& samples,
                           const std::array<std::int64_t, 2>& outputs)
    : device_(std::move(device)), samples_(samples), outputs_(outputs) {}

void DevicePlanes::run(const std::vector<Channel>& channels, int threads, const Filter& filter) const {
  Device::Parts& parts = device_->parts();
  std::unique_lock lock(parts.lock);
  if (parts.lost) throw DeviceError(parts.info.name + " does not run again: " + *parts.failure);
  try {
    if (parts.fault == DeviceFault::run) throw DeviceError("a fault that was asked for");
    if (parts.fault == DeviceFault::memory) throw DeviceMemoryError("no memory left, as was asked for");
    for (std::size_t c = 0; c < channels.size(); ++c) filter_one(channels[c], c + 1, threads, filter);
  } catch (const DeviceError& error) {
    parts.fail(error);
  }
  if (stays(channels.front())) {
    *channels.front().stays = std::make_unique<DeviceImage>(device_, outputs_[0], outputs_[1], std::move(lock));
    return;
  }
  // Nothing is written before all has been filtered: whoever takes over finds the planes as they were.
  for (std::size_t c = 0; c < channels.size(); ++c)
    deliver(channels[c], parts.pinned(c + 1, bytes_of(outputs_)), threads);
}

std::int64_t DevicePlanes::bytes(std::int64_t channels) const {
  return static_cast<std::int64_t>(bytes_of(samples_)) + channels * static_cast<std::int64_t>(bytes_of(outputs_));
}

void DevicePlanes::launch(const char* kernel, std::int64_t x, std::int64_t y,
                          std::initializer_list<KernelArgument> arguments) const {
  Device::Parts& parts = device_->parts();
  parts.backend->launch(parts.queue, kernel, {x, y, 1}, {arguments.begin(), arguments.size()});
}

std::shared_ptr<const DeviceMemory> DevicePlanes::sent_bytes(const void* list, std::size_t bytes) const {
  Device::Parts& parts = device_->parts();
  std::shared_ptr<const DeviceMemory> memory = parts.backend->allocate(bytes);
  parts.backend->upload(parts.queue, list, *memory, bytes);
  parts.backend->finish(parts.queue);
  return memory;
}

const DeviceMemory& DevicePlanes::sent_scene(const Channel& channel, bool on_host, int threads) const {
  Device::Parts& parts = device_->parts();
  const std::size_t bytes = bytes_of(samples_);
  KeptOnDevice* const kept = channel.kept != nullptr && !on_host ? &channel.kept->on_device : nullptr;
  if (kept != nullptr && kept->device == device_) return *static_cast<const DeviceMemory*>(kept->memory.get());
  const PinnedMemory& from = parts.pinned(0, bytes);
  parallel_for_each(samples_[1], 64, threads, [&](std::int64_t y) {
    float* const row = from.floats() + y * samples_[0];
    if (on_host)
      kernels::center(channel.in.row(y), samples_[0], channel.mean, channel.scale, row);
    else
      std::copy_n(channel.in.row(y), samples_[0], row);
  });
  const std::shared_ptr<const DeviceMemory> own = kept != nullptr ? parts.backend->allocate(bytes) : nullptr;
  const DeviceMemory& to = own ? *own : parts.memory(Device::Parts::Place::scene, bytes);
  parts.backend->upload(parts.queue, from.data, to, bytes);
  if (own) {
    kept->memory = nullptr;  // before the device that it may be of
    kept->device = device_;
    kept->memory = own;
  }
  return to;
}

// To the pinned memory of that number.
void DevicePlanes::filter_one(const Channel& channel, std::size_t number, int threads, const Filter& filter) const {
  Device::Parts& parts = device_->parts();
  DeviceBackend& device = *parts.backend;
  const bool on_host = is_extreme(channel);
  const double mean = on_host ? 0.0 : channel.mean, scale = on_host ? 1.0 : channel.scale;
  const double out_mean = on_host ? 0.0 : channel.out_mean();
  const auto float_mean = static_cast<float>(out_mean);
  const DevicePlane plane{.scene = sent_scene(channel, on_host, threads),
                          .image = parts.memory(Device::Parts::Place::image, bytes_of(outputs_)),
                          .mean = static_cast<float>(mean),
                          .scale = static_cast<float>(scale),
                          .border = static_cast<float>((channel.border_value - channel.mean) * channel.scale),
                          .unscale = static_cast<float>(1.0 / scale),
                          .out_mean = float_mean,
                          .beyond = static_cast<float>(out_mean - static_cast<double>(float_mean))};
  const bool timed = parts.kernels_ms.has_value();
  const DeviceBackend::Event start = timed ? device.mark(parts.queue) : 0;
  filter(plane);
  const DeviceBackend::Event end = timed ? device.mark(parts.queue) : 0;
  if (stays(channel)) return;
  const PinnedMemory& to = parts.pinned(number, bytes_of(outputs_));
  device.download(parts.queue, plane.image, to.data, bytes_of(outputs_));
  device.finish(parts.queue);
  if (timed) parts.kernels_ms = device.ms_between(start, end);
  if (parts.fault == DeviceFault::values) to.floats()[0] += plane.unscale;
}

void DevicePlanes::deliver(const Channel& channel, const PinnedMemory& image, int threads) const {
  parallel_for_each(outputs_[1], 64, threads, [&](std::int64_t y) {
    float* const row = image.floats() + y * outputs_[0];
    if (is_extreme(channel)) kernels::restore(row, outputs_[0], channel.out_mean(), 1.0 / channel.scale, row);
    if (channel.take)
      channel.take(y, 0, {row, static_cast<std::size_t>(outputs_[0])});
    else
      std::copy_n(row, outputs_[0], channel.out.row(y));
  });
}

}  // namespace mtf
