// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the engines on a device share, whatever they do there: scenes sent to it, and once where they come again, images
// brought back or left there, and failures noted.

#include <array>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "mtf/device/device_parts.h"
#include "mtf/engines/engine.h"

namespace mtf {

/// A plane on the device, and its numbers as kernels take them: the canvas is (sample - mean) scale, or `border`; the
/// image is value unscale + out_mean, of which float leaves `beyond`.
struct DevicePlane {
  const DeviceMemory &scene, &image;
  float mean, scale, border, unscale, out_mean, beyond;
};

/// Why a device has no room for so many bytes, `largest` of them in one piece: "" where it has.
std::string memory_obstacle(const DeviceInfo& info, std::int64_t largest, std::int64_t needed);

/// Milliseconds of a scene to the device and of an image back.
double transfers_ms(const DeviceTest& test, std::int64_t samples, std::int64_t outputs);

class DevicePlanes {
 public:
  /// Sizes: columns, rows.
  DevicePlanes(std::shared_ptr<const Device> device, const std::array<std::int64_t, 2>& samples,
               const std::array<std::int64_t, 2>& outputs);

  /// Asks for the kernels that make the image of a plane.
  using Filter = std::function<void(const DevicePlane& plane)>;
  /// What Engine::run does. Throws DeviceError, and has written nothing then.
  void run(const std::vector<Channel>& channels, int threads, const Filter& filter) const;
  /// Of one run of so many channels.
  std::int64_t bytes(std::int64_t channels) const;

  // For filters, and for those that make one: the device is theirs while they hold Device::Parts::lock.
  void launch(const char* kernel, std::int64_t x, std::int64_t y,
              std::initializer_list<KernelArgument> arguments) const;
  template <class T>
  std::shared_ptr<const DeviceMemory> sent(const std::vector<T>& list) const {
    return sent_bytes(list.data(), list.size() * sizeof(T));
  }
  Device::Parts& parts() const { return device_->parts(); }

 private:
  std::shared_ptr<const DeviceMemory> sent_bytes(const void* list, std::size_t bytes) const;
  /// The samples on the device: as they are, or about the mean (`on_host`).
  const DeviceMemory& sent_scene(const Channel& channel, bool on_host, int threads) const;
  void filter_one(const Channel& channel, std::size_t number, int threads, const Filter& filter) const;
  void deliver(const Channel& channel, const PinnedMemory& image, int threads) const;

  std::shared_ptr<const Device> device_;
  std::array<std::int64_t, 2> samples_, outputs_;
};

}  // namespace mtf
