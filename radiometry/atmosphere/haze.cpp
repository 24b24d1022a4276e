// SPDX-License-Identifier: Apache-2.0
#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/atmosphere/haze_impl.h"

namespace radiometry::atmosphere {

Season season_of(ModelAtmosphere model) {
  return model == ModelAtmosphere::mid_latitude_winter || model == ModelAtmosphere::subarctic_winter
             ? Season::autumn_winter
             : Season::spring_summer;
}

double usual_visibility_m(HazeKind kind) {
  constexpr std::array<double, kHazeNames.size()> kVisibility_m{23e3, 23e3, 5e3, 23e3, 50e3, 200.0, 500.0};
  return kVisibility_m[static_cast<std::size_t>(kind)];
}

void require_haze(double visibility_m, double rain_mm_h) {
  if (!(visibility_m >= 10.0 && visibility_m <= 1e6))
    throw mtf::UsageError("air: a visibility of " + mtf::format_double(visibility_m) +
                          " m; it has to be from 10 m to 1000 km (metres, not kilometres)");
  if (!(rain_mm_h >= 0.0 && rain_mm_h <= 300.0))
    throw mtf::UsageError("air: rain of " + mtf::format_double(rain_mm_h) + " mm/h; it has to be from 0 to 300");
}

template void require_valid(const Air<double>&);
template std::array<double, kAerosolRegions> aerosol_per_km(const Haze<double>&, double);
template double rain_per_km(const double&);

}  // namespace radiometry::atmosphere
