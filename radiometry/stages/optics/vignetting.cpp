// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/vignetting.h"

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/stages/noise/fixed_pattern.h"

namespace radiometry {
namespace {

using mtf::UsageError;

void require_map(const Vignetting& vignetting, mtf::ImageView<const float> given, mtf::ImageView<const float> factors,
                 Origin origin) {
  if (given.data == nullptr) throw UsageError("vignetting.map: the image " + vignetting.map + " was not given");
  if (vignetting.a2 != 0.0 || vignetting.a4 != 0.0 || vignetting.a6 != 0.0)
    throw UsageError("vignetting: give either a map or the coefficients a2, a4, a6");
  if (given.width != factors.width || given.height != factors.height)
    throw UsageError("vignetting.map: " + vignetting.map + " has " + std::to_string(given.width) + " x " +
                     std::to_string(given.height) + " pixels, the detector's region " + std::to_string(factors.width) +
                     " x " + std::to_string(factors.height) + "; give one of its size");
  require_numbers("vignetting.map: " + vignetting.map, given, 0.0F, origin);
}

}  // namespace

void vignetting_map(mtf::ImageView<float> factors, const Vignetting& vignetting, const FocalPlane& detector,
                    double focal_length_mm, Origin origin, mtf::ImageView<const float> given, int threads) {
  require_valid("vignetting", vignetting);
  require_region(detector, origin, factors.width, factors.height);
  if (!(focal_length_mm > 0.0))
    throw UsageError("vignetting: a focal length of " + mtf::format_double(focal_length_mm) +
                     " mm; it has to be above 0");
  const bool has_map = !vignetting.map.empty() || given.data != nullptr;
  if (has_map) require_map(vignetting, given, factors, origin);
  const double scale = 1.0 / detector.half_diagonal_um();
  const auto row = [&](std::int64_t y) {
    const double y_um = detector.y_um(origin.y + y);
    for (std::int64_t x = 0; x < factors.width; ++x) {
      const double distance_um = std::hypot(detector.x_um(origin.x + x), y_um), r = distance_um * scale, r2 = r * r;
      const double polynomial = 1.0 + r2 * (vignetting.a2 + r2 * (vignetting.a4 + r2 * vignetting.a6));
      const double fall = vignetting.cos4 ? cos4_factor(distance_um, focal_length_mm) : 1.0;
      const double lost = has_map ? static_cast<double>(given.at(x, y)) : std::max(0.0, polynomial);
      factors.at(x, y) = static_cast<float>(fall * lost);
    }
  };
  constexpr std::int64_t kRowsAtOnce = 16;
  mtf::parallel_for(factors.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) row(y);
  });
}

}  // namespace radiometry
