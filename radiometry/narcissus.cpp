// SPDX-License-Identifier: Apache-2.0
#include "radiometry/narcissus.h"

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

void subtract_narcissus(mtf::ImageView<float> image, mtf::ImageView<const float> map, double background_e) {
  if (!(background_e >= 0.0 && std::isfinite(background_e)))
    throw mtf::UsageError("narcissus: a background of " + mtf::format_double(background_e) +
                          " electrons; it has to be 0 or above and finite");
  if (map.width != image.width || map.height != image.height)
    throw mtf::UsageError("narcissus: a map of " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                          " pixels for an image of " + std::to_string(image.width) + " x " +
                          std::to_string(image.height) + "; give one of its size");
  for (std::int64_t y = 0; y < image.height; ++y) {
    float* row = image.row(y);
    const float* missing = map.row(y);
    for (std::int64_t x = 0; x < image.width; ++x)
      row[x] -= static_cast<float>(background_e * static_cast<double>(missing[x]));
  }
}

}  // namespace radiometry
