// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/optics/vignetting.h"

#include <algorithm>
#include <vector>

#include "mtf/parallel.h"
#include "radiometry/stages/noise/fixed_pattern.h"

namespace radiometry {
namespace {

using mtf::UsageError;

void require_map(const Vignetting& vignetting, mtf::ImageView<const float> given, mtf::ImageView<const float> factors,
                 Origin origin) {
  const bool of_pupil = vignetting.of == VignettingOf::wavefront;
  if (given.data == nullptr)
    throw UsageError(of_pupil ? "vignetting.of: the shares of the pupil were not given"
                              : "vignetting.map: the image " + vignetting.map + " was not given");
  if (of_pupil && !vignetting.map.empty())
    throw UsageError("vignetting.map: given beside of = \"wavefront\"; remove one of them");
  if (vignetting.a2 != 0.0 || vignetting.a4 != 0.0 || vignetting.a6 != 0.0)
    throw UsageError(std::string("vignetting: give either ") + (of_pupil ? "of = \"wavefront\"" : "a map") +
                     " or the coefficients a2, a4, a6");
  if (given.width != factors.width || given.height != factors.height)
    throw UsageError("vignetting.map: " + vignetting.map + " has " + size_of(given.width, given.height) +
                     " pixels, the detector's region " + size_of(factors.width, factors.height) +
                     "; give one of its size");
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
  const bool has_map = !vignetting.map.empty() || vignetting.of == VignettingOf::wavefront || given.data != nullptr;
  if (has_map) require_map(vignetting, given, factors, origin);
  const double half_diagonal_um = detector.half_diagonal_um(), focal_length_um = 1e3 * focal_length_mm;
  const auto square_of = [](double number) { return number * number; };
  const double by_diagonal = square_of(1.0 / half_diagonal_um),
               by_focal_length = vignetting.cos4 ? square_of(1.0 / focal_length_um) : 0.0;
  std::vector<double> x2;
  for (std::int64_t x = 0; x < factors.width; ++x) x2.push_back(square_of(detector.x_um(origin.x + x)));
  constexpr std::int64_t kRowsAtOnce = 16;
  mtf::parallel_for_each(factors.height, kRowsAtOnce, threads, [&](std::int64_t y) {
    const double y2 = square_of(detector.y_um(origin.y + y));
    float* out = factors.row(y);
    for (std::int64_t x = 0; x < factors.width; ++x) {
      const double distance2 = x2[static_cast<std::size_t>(x)] + y2, r2 = distance2 * by_diagonal;
      const double polynomial = 1.0 + r2 * (vignetting.a2 + r2 * (vignetting.a4 + r2 * vignetting.a6));
      const double lost = has_map ? static_cast<double>(given.at(x, y)) : std::max(0.0, polynomial);
      out[x] = static_cast<float>(cos4_factor(distance2 * by_focal_length) * lost);
    }
  });
}

}  // namespace radiometry
