// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is kept of one plane of a KeptScene: everything that a run makes of it before the OTF comes in.

#include <cstddef>
#include <memory>
#include <optional>

#include "mtf/engines/fft/line_groups.h"
#include "mtf/engines/mean_and_deviation.h"
#include "mtf/engines/uniform_runs.h"
#include "mtf/image.h"

namespace mtf {

/// The spectrum of a plane, as a spectral engine multiplies it by an OTF, and what the engine knows of the plane.
struct KeptSpectrum {
  /// What it is good for, besides the plane.
  struct Key {
    std::shared_ptr<const void> transforms;              ///< stands for the engine that made it; null: there is none
    double mean = 0.0, scale = 1.0, border_value = 0.0;  ///< of the channel
    bool operator==(const Key&) const = default;
  };
  Key key;
  double mean = 0.0, scale = 1.0;  ///< with which it was made: those of the channel, or of all samples (is_near)
  double std = 0.0;                ///< of the plane, scaled
  LineGroups input;
  AlignedBuffer<std::byte> numbers;  ///< [block][row][kRow], after the transforms along both axes
};

/// A plane in the memory of a device.
struct KeptOnDevice {
  std::shared_ptr<const void> device, memory;  ///< the memory goes first
};

struct KeptPlane {
  std::optional<MeanAndDeviation> all;  ///< from all samples, where they had to be read for it
  UniformRuns flat;                     ///< found by the same pass
  KeptSpectrum spectrum;
  KeptOnDevice on_device;
};

}  // namespace mtf
