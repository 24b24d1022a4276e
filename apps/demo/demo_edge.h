// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edge of `mtf demo`: a slanted edge as imaged by the demo's sensor, to measure and to fit.

#include "mtf/image.h"
#include "mtf/io/config/config.h"

namespace apps {

/// Image of an edge whose normal points 5 degrees above +x, 128 x 128 pixels, with a little noise. The scene is a step
/// blurred by a Gaussian that the simulation divides out again, so that its samples alias nothing; the frame's border
/// is cut off, where mirroring bends the edge.
mtf::Image demo_edge(const mtf::io::SensorConfig& sensor, int threads);

/// The sensor file with its jitter to be fitted, starting from a value that is wrong.
std::string demo_fit_config(const mtf::io::SensorConfig& sensor);

}  // namespace apps
