// SPDX-License-Identifier: Apache-2.0
#pragma once

// The device that tests run on: the one whose id MTFKIT_TEST_DEVICE names, else the first, which is PoCL's where there
// is no other.

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>

#include "mtf/device/device.h"

namespace mtf::test {

inline std::optional<DeviceInfo> tested_device() {
  const char* const id = std::getenv("MTFKIT_TEST_DEVICE");
  for (const DeviceInfo& info : devices().devices)
    if (id == nullptr || info.id == id) return info;
  return std::nullopt;
}

/// Open, for all tests of a process; null where there is none.
inline std::shared_ptr<const Device> open_tested_device() {
  static const std::shared_ptr<const Device> device = [] {
    const std::optional<DeviceInfo> info = tested_device();
    return info ? open_device(*info) : nullptr;
  }();
  return device;
}

}  // namespace mtf::test
