// SPDX-License-Identifier: Apache-2.0
#pragma once

// Graphics cards and other devices that filter images in place of the processor, with the same promise. All that
// speaks to a driver is in modules opened at run time, libmtfkit_cuda.so and libmtfkit_opencl.so
// (mtf/device/backend.h): a program that asks for no device loads none of it.
//
//   std::string note;
//   PlanOptions options{.device = choose_device("auto", note)};   // the plan still takes what is faster
//
// A device is admitted by a test of itself when it is opened: its filter against transforms in double, its random
// numbers and elementary functions bit for bit against the processor's. One that fails is refused by name.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/error.h"

namespace mtf {

/// The driver or the device failed: device lost, wrong numbers.
class DeviceError : public RuntimeError {
 public:
  using RuntimeError::RuntimeError;
};

/// The device has no memory left at the moment; it may have some later.
class DeviceMemoryError : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

struct DeviceInfo {
  std::string id;  ///< "cuda0", "opencl1": the backend and its own count
  std::string name, vendor, driver;
  std::string backend;             ///< "cuda" or "opencl"
  std::int64_t bytes = 0;          ///< memory of the device
  std::int64_t largest_bytes = 0;  ///< of one piece of it
  bool cpu = false;                ///< the processor itself, by a driver that runs kernels on it
  bool doubles = false;            ///< its kernels may compute in double precision
  int index = 0;                   ///< of the backend's devices
};

/// All devices, those of CUDA first, and why a backend has none.
struct DeviceList {
  std::vector<DeviceInfo> devices;
  std::vector<std::string> notes;
};
DeviceList devices();

/// What a device was found to do when it was opened.
struct DeviceTest {
  std::array<double, 2> rms{};        ///< error of the filters of the test, relative to the std of their scene
  double rounding = 1.0;              ///< the factor, at least 1, of the rounding that a plan predicts for float
  std::array<double, 2> filter_ms{};  ///< their time, scene and image on the device
  double upload_ns = 0.0;             ///< a byte, from ordinary memory
  double download_ns = 0.0;           ///< and back
  double transfer_ms = 0.0;           ///< of next to nothing
};

/// Wrong on purpose, for tests: random words, filtered values, or runs that end as those of a lost device or of one
/// without memory, or a device that is lost after the filter.
enum class DeviceFault { none, words, values, run, memory, chain };

/// An open device. Runs of several threads follow one another.
class Device {
 public:
  struct Parts;
  explicit Device(std::unique_ptr<Parts> parts);
  ~Device();
  const DeviceInfo& info() const;
  const DeviceTest& test() const;
  /// The last failure. After it the device runs again only where memory was missing.
  std::optional<std::string> failure() const;
  /// For the engine (mtf/device/device_filter.h).
  Parts& parts() const { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

/// Opens a device and tests it; a device that is open is shared. Throws DeviceError, with the reason, for one that
/// cannot be opened or is not admitted.
std::shared_ptr<const Device> open_device(const DeviceInfo& info, DeviceFault fault = DeviceFault::none);

/// The device that a plan may use.
struct DeviceChoice {
  std::shared_ptr<const Device> device;  ///< null: the processor alone
  bool insisted = false;                 ///< by name: its failures are errors. Else the processor takes over
};

/// By word: "cpu", none; "auto", the first admitted device that is not the processor, or none, and `note` says why;
/// else the first whose id it is or whose name has it (any case), insisted on: throws UsageError where there is none,
/// and as open_device() does.
DeviceChoice choose_device(std::string_view word, std::string& note);

}  // namespace mtf
