// SPDX-License-Identifier: Apache-2.0
#pragma once

// The inside of an open device: its backend, what runs share, and the test that admits it.

#include <map>
#include <mutex>
#include <utility>

#include "mtf/device/backend.h"
#include "mtf/image.h"

namespace mtf {

struct Device::Parts {
  DeviceInfo info;
  DeviceTest test;
  double tap_ns = 0.0;  ///< of a weight of a direct kernel at a pixel (device_taps.h), as the test has measured it
  DeviceFault fault = DeviceFault::none;
  std::unique_ptr<DeviceBackend> backend;
  DeviceBackend::Queue queue = 0;

  mutable std::mutex lock;  ///< of all below, and held while something runs
  std::optional<std::string> failure;
  bool lost = false;                 ///< it does not run again
  std::optional<double> kernels_ms;  ///< where it has a value, runs put there the time between the transfers

  /// Memory that every run takes again, as large as the largest has needed.
  enum class Place { scene, canvas, spectrum, image, frames, counts, numbers, bins, whole };
  const DeviceMemory& memory(Place place, std::size_t bytes);
  const PinnedMemory& pinned(std::size_t number, std::size_t bytes);
  DeviceFft& fft(const FftShape& shape);
  /// An image that does not change, sent once for as long as it is there.
  const DeviceMemory& map(const std::shared_ptr<const Image>& image);
  void give_back();  ///< all memory that runs take again
  /// Notes a failure of work on the device, and throws it with the device's name.
  [[noreturn]] void fail(const DeviceError& error);

 private:
  static constexpr std::size_t kMostFfts = 16;
  std::array<std::shared_ptr<const DeviceMemory>, 9> places_;
  std::vector<std::shared_ptr<const PinnedMemory>> pinned_;
  std::vector<std::pair<FftShape, std::shared_ptr<DeviceFft>>> ffts_;  ///< the latest last
  std::vector<std::pair<std::weak_ptr<const Image>, std::shared_ptr<const DeviceMemory>>> maps_;
};

/// The texts of mtf/device/kernels.cl, poisson.cl, quantiles.cl and pixels.cl.
extern const char* const kKernelText;

/// What the kernel `bits` writes for an input: four random words, then the bits of -log, cos, sin and a fused sum, and
/// where the device has doubles those of a square root and of a sum in double.
inline constexpr std::size_t kBitsOfInput = 10;
/// The same by the processor, from the same text.
std::vector<std::uint32_t> bits_on_host(std::int64_t inputs);

/// Runs the test, and measures. Throws DeviceError with what is wrong.
void admit(const std::shared_ptr<const Device>& device);

}  // namespace mtf
