// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/narcissus.h"

#include <cmath>

namespace radiometry {

void narcissus_map(mtf::ImageView<float> map, const Narcissus& narcissus, const FocalPlane& detector, Origin origin) {
  require_valid("narcissus", narcissus);
  require_region(detector, origin, map.width, map.height);
  const double scale = 1.0 / (detector.half_diagonal_um() * narcissus.radius);
  const double power = narcissus.profile == NarcissusProfile::gaussian ? 1.0 : 4.0;
  for (std::int64_t y = 0; y < map.height; ++y) {
    const double down = detector.y_um(origin.y + y) * scale;
    for (std::int64_t x = 0; x < map.width; ++x) {
      const double across = detector.x_um(origin.x + x) * scale;
      const double t2 = across * across + down * down;
      map.at(x, y) = static_cast<float>(narcissus.depth * std::exp2(-std::pow(t2, power)));
    }
  }
}

}  // namespace radiometry
