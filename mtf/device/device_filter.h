// SPDX-License-Identifier: Apache-2.0
#pragma once

// The spectral engine on a device: the same canvas, OTF and sum of aliases as that of the processor in the fourier
// basis (mtf/engines/fft), in six steps that leave the device only at both ends.
//   upload     the scene, by memory that the device reads by itself
//   gather     canvas = (sample - mean) scale, at its borders by a table of each axis (canvas_sources)
//   forward    real transform of the canvas
//   fold       detector spectrum = sum over aliases of OTF x phase x spectrum, by the terms of each axis (axis_terms)
//   inverse    transform of the detector's length
//   scatter    pixels = value / scale + mean of the image; download, unless the image stays (Channel::stays)
//
// A plane that comes again (Channel::kept) is sent once.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mtf/device/device.h"
#include "mtf/engines/engine.h"
#include "mtf/engines/fft/axis.h"

namespace mtf {

/// H(kx, ky) of the frequencies kx = 0 .. keep - 1 of x, one row for each of otf_frequencies(y).
struct DeviceOtf {
  bool complex = false;
  std::vector<float> values;  ///< a number each, or real and imaginary part
};

/// Why a device cannot filter between these axes: "" where it can.
std::string device_obstacle(const DeviceInfo& info, const AxisTransform& x, const AxisTransform& y, bool complex);

/// Memory of the device that a filter takes, with that of its transforms.
std::int64_t device_bytes(const AxisTransform& x, const AxisTransform& y, bool complex);

/// Milliseconds of one plane, transfers included, by what the device's test has measured.
double device_cost_ms(const Device& device, const AxisTransform& x, const AxisTransform& y);

/// Both axes in the fourier basis, without obstacle. Throws DeviceError; so does its run().
std::shared_ptr<const SpectralFilter> make_device_filter(std::shared_ptr<const Device> device, const AxisTransform& x,
                                                         const AxisTransform& y, DeviceOtf otf);

}  // namespace mtf
