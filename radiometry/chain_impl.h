// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of a compiled chain (chain.h): what is the same for every frame is made once.

#include <mutex>

#include "radiometry/chain.h"

namespace radiometry {

/// A number for every pixel, or one for all.
struct Factor {
  double number = 1.0;
  mtf::Image map{};  ///< empty: the number alone

  bool uniform() const { return map.size() == 0; }
};

/// image = gain x image + offset.
void multiply_add(mtf::Image& image, const Factor& gain, const Factor& offset, int threads);

struct Chain::Impl {
  explicit Impl(mtf::SensorPlan filters) : plan(std::move(filters)) {}

  mtf::SensorPlan plan;
  SensorSettings settings;
  OutputStage last = OutputStage::electrons;
  std::uint64_t seed = 0;
  Origin origin;
  FocalPlane detector;
  Camera<double> camera;
  Pixel<double> pixel;
  std::optional<Adc> adc;
  std::optional<Response> response;
  double gain = 0.0;    ///< electrons for one unit of weighted radiance on the axis
  mtf::Image corners;   ///< vignetting; empty: none
  Factor light;         ///< electrons for one unit of weighted radiance
  Factor glow;          ///< mean electrons of warm optics, stop and dark current
  mtf::Image offset;    ///< electrons added to every frame; empty: none
  double read_e = 0.0;  ///< rms of read, reset and other noise
  double frame_time_s = 0.0;
  std::vector<DefectivePixel> defects;
  std::vector<BlinkingPixel> blinking;

  struct Run;  ///< of one frame, chain_run.cpp
  /// Measured when it is first needed, by the first chain of a sequence.
  const TwoPoint& correction(int threads) const;
  TwoPoint measure(int threads) const;
  std::shared_ptr<const Impl> corrected_by;  ///< the first chain of a sequence; null: this one
  mutable std::once_flag measured_once;
  mutable TwoPoint measured;
};

}  // namespace radiometry
