// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a module of devices gives: its devices, and one that is open. Nothing above it knows OpenCL or CUDA, nothing
// below it knows images. Work goes to queues; that of one queue is done in order. Calls for one open device come one
// after another, from any thread; memory alone is given back at any time. Whatever fails is a DeviceError with the call
// and the driver's reason.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "mtf/device/device.h"
#include "mtf/work/module.h"

namespace mtf {

/// Memory of a device, given back with its last owner.
struct DeviceMemory {
  std::uint64_t handle = 0;  ///< what a kernel takes for it
  std::size_t bytes = 0;
};

/// Memory of the host that the device reads and writes by itself, given back with its last owner.
struct PinnedMemory {
  void* data = nullptr;
  std::size_t bytes = 0;
  float* floats() const { return static_cast<float*>(data); }
};

/// An argument of a kernel: a number, or memory by its handle.
class KernelArgument {
 public:
  template <class T>
  requires std::is_arithmetic_v<T> KernelArgument(T number) : bytes_(sizeof number) {  // NOLINT: as it stands in a list
    std::memcpy(value_.data(), &number, sizeof number);
  }
  KernelArgument(const DeviceMemory& memory) : KernelArgument(memory.handle) {}                   // NOLINT
  KernelArgument(const std::shared_ptr<const DeviceMemory>& memory) : KernelArgument(*memory) {}  // NOLINT

  const void* data() const { return value_.data(); }
  std::size_t bytes() const { return bytes_; }

 private:
  alignas(8) std::array<std::byte, 8> value_{};
  std::size_t bytes_ = 0;
};

/// Real transforms of planes of width x height floats, sign -1, or back, unnormalised, in place: rows of
/// 2 (width / 2 + 1) floats. Each takes a second or so to prepare.
struct FftShape {
  bool operator==(const FftShape&) const = default;
  std::int64_t width = 0, height = 0, batch = 1;
  bool forward = true;
};

/// One that is ready, of one queue.
class DeviceFft {
 public:
  virtual ~DeviceFft() = default;
  virtual void run(const DeviceMemory& planes) = 0;
};

class DeviceBackend {
 public:
  using Queue = int;
  using Event = int;

  virtual ~DeviceBackend() = default;
  virtual Queue make_queue() = 0;
  virtual std::shared_ptr<const DeviceMemory> allocate(std::size_t bytes) = 0;
  virtual std::shared_ptr<const PinnedMemory> allocate_pinned(std::size_t bytes) = 0;
  /// The memory of the host has to stay until the queue is finished.
  virtual void upload(Queue queue, const void* from, const DeviceMemory& to, std::size_t bytes) = 0;
  virtual void download(Queue queue, const DeviceMemory& from, void* to, std::size_t bytes) = 0;
  /// A kernel of the text that the device was opened with, on a grid of at least `threads` along x, y and z.
  virtual void launch(Queue queue, const std::string& kernel, std::array<std::int64_t, 3> threads,
                      std::span<const KernelArgument> arguments) = 0;
  virtual std::shared_ptr<DeviceFft> fft(Queue queue, const FftShape& shape) = 0;
  virtual void finish(Queue queue) = 0;
  virtual Event mark(Queue queue) = 0;  ///< in the queue's order
  /// Between two marks of finished queues; both are given up.
  virtual double ms_between(Event from, Event to) = 0;
};

/// The table of mtfkit_opencl and mtfkit_cuda.
struct DeviceModule {
  ModuleBuild build;
  /// Without names of their own (DeviceInfo::id). Throws DeviceError where there are none, with the reason.
  std::vector<DeviceInfo> (*list)();
  /// With the kernels of a text compiled.
  std::unique_ptr<DeviceBackend> (*open)(int index, const std::string& kernels);
};

}  // namespace mtf
