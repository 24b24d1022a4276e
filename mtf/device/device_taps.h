// SPDX-License-Identifier: Apache-2.0
#pragma once

// A direct kernel (mtf/engines/taps) on a device: sums of samples by weights, each pixel a thread, on a canvas that
// holds the samples beyond the edges too.

#include <memory>
#include <string>
#include <vector>

#include "mtf/border.h"
#include "mtf/device/device.h"
#include "mtf/engines/taps/taps.h"

namespace mtf {

/// Why a device cannot do it: "" where it can.
std::string device_taps_obstacle(const DeviceInfo& info, const TapAxis& x, const TapAxis& y);

/// Memory of the device that it takes.
std::int64_t device_taps_bytes(const TapAxis& x, const TapAxis& y);

/// Milliseconds of one plane, transfers included, by what the device's test has measured; `used` taps are not zero.
double device_taps_cost_ms(const Device& device, const TapAxis& x, const TapAxis& y, std::int64_t used);

/// As make_direct_engine(), without obstacle. Throws DeviceError; so does its run().
std::shared_ptr<const Engine> make_device_taps(std::shared_ptr<const Device> device, const TapAxis& x, const TapAxis& y,
                                               Border border, const std::vector<float>& taps);

}  // namespace mtf
