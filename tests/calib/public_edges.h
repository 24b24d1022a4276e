// SPDX-License-Identifier: Apache-2.0
#pragma once

// The public edges with known MTF, $MTFKIT_SHARED/data/edges.

#include <string>
#include <vector>

#include "mtf/image.h"

namespace public_edges {

struct Case {
  std::string file;
  std::string psf;
  std::string encoding;  ///< linear | sRGB
  double angle_deg = 0.0;
  double bits = 16.0;
  double x = 0.0, y = 0.0;  ///< a point of the edge; pixel centres at + 0.5
  double noise_sigma = 0.0, sagitta_px = 0.0;
  double mtf50 = 0.0;
  std::vector<double> frequency, mtf;
};

/// Empty without the data.
std::vector<Case> cases();
/// The image as a linear fraction of full scale.
mtf::Image read(const Case& one);
std::string folder();

}  // namespace public_edges
