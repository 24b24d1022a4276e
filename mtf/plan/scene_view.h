// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mtf/frame.h"
#include "mtf/grid.h"
#include "mtf/image.h"

namespace mtf {

/// A scene in memory: one plane of samples, and how far they lie apart.
struct SceneView {
  ImageView<const float> samples;
  AxisPair<double> step;      ///< length at the focal plane, object angle, or detector pixels; one, or x and y apart
  double border_value = 0.0;  ///< of what lies beyond the scene with Border::constant
};

/// The scene's samples at the focal plane of that frame.
SampleGrid grid_of(const SceneView& scene, const Frame<double>& frame);

}  // namespace mtf
