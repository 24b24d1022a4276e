// SPDX-License-Identifier: Apache-2.0
#pragma once

// The parts of a compiled chain (chain.h): what is the same for every frame is made once.

#include "radiometry/chain.h"

namespace radiometry {

/// A number for every pixel, or one for all.
struct Factor {
  double number = 1.0;
  mtf::Image map;  ///< empty: the number alone

  bool uniform() const { return map.size() == 0; }
};

struct Chain::Impl {
  explicit Impl(mtf::SensorPlan filters) : plan(std::move(filters)) {}

  mtf::SensorPlan plan;
  SensorSettings settings;
  Origin origin;
  Camera<double> camera;
  Pixel<double> pixel;
  std::optional<Adc> adc;
  Signal<double> background;
  Factor light;       ///< electrons for one unit of weighted radiance
  Factor glow;        ///< mean electrons of warm optics, stop and dark current
  mtf::Image offset;  ///< electrons added to every frame; empty: none
  std::vector<DefectivePixel> defects;
};

}  // namespace radiometry
