// SPDX-License-Identifier: Apache-2.0
#pragma once

// A cooled camera and the air before it, for tests of planes with a path for each pixel.

#include <cmath>
#include <vector>

#include "radiometry/light/path_planes.h"

namespace radiometry::test {

inline SpectralCamera cooled_camera() {
  return {.band = {3.0, 5.0},
          .optics = {},
          .cold_filter = {make_spectrum("filter", {3.3, 3.5, 4.7, 4.9}, {0.0, 0.9, 0.88, 0.0}, 1.0)},
          .quantum_efficiency = {make_spectrum("qe", {3.0, 3.4, 4.6, 5.2}, {0.1, 0.7, 0.8, 0.0}, 1.0)}};
}

/// A clear window, a strong line of exp(-30) and an opaque one: a path takes more of one temperature's light than of
/// another's.
inline PathTable lines_of_air() {
  const std::vector<double> range{100.0, 1000.0, 5000.0};
  std::vector<std::vector<double>> tau, radiance;
  for (const double r : range) {
    tau.push_back({std::exp(-1e-5 * r), std::exp(-6e-3 * r), r < 500.0 ? 0.2 : 0.0, std::exp(-2e-4 * r)});
    radiance.push_back({1e-5 * r, 1e-3 * (1.0 - std::exp(-6e-3 * r)), 2e-3, 1e-4 * std::sqrt(r)});
  }
  return {"air.csv", range, {3.0, 3.8, 4.3, 5.0}, tau, radiance};
}

}  // namespace radiometry::test
