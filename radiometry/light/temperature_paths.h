// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene of temperatures through a path whose length differs from pixel to pixel. Each surface has the spectrum of its
// own temperature, and a path takes more of one spectrum than of another: the band integral of emission x path is
//   L(T, r) = E(T) tau(T, r) + E'(Ts) tau'(Ts, r) + path(r),
//   E(T) = integral of R eps B(T),   tau(T, r) = (integral of R eps B(T) tau(r)) / E(T),
// E' and tau' the same with 1 - eps, R the camera's curves (scene_radiance.h), Ts what the surfaces reflect. tau(T, r)
// by range is the RangeTable of a source of temperature T (path_planes.h); between temperatures it is the polynomial of
// 1/T through Chebyshev points of the scene's temperatures, 3, 5, 9 or 17 of them, until twice as many change tau E
// by less than 1e-7 of the hottest E.

#include "radiometry/light/path_planes.h"

namespace radiometry {

/// tau(T, r).
class TemperatureRangeTable {
 public:
  /// For temperatures from coldest_k to hottest_k; colder ones, whose emission is below 1e-12 of the hottest one's, may
  /// be taken as the least that is not. Throws UsageError as RangeTable, and for temperatures that are not 0 or above.
  TemperatureRangeTable(const SceneBand& scene, const PathTable& table, double coldest_k, double hottest_k);

  /// At a range in [0, longest]; a temperature beyond the ends is taken as the end.
  double transmission(double temperature_k, double range_m) const;
  /// What the last doubling of the temperatures changed of tau, at most, as a share of the light of the hottest: what
  /// cold surfaces emit beside it counts as little in the image. The error of tau E / E(hottest) is below it.
  double error() const { return error_; }

 private:
  std::vector<double> inverse_k_;   ///< of the tables, falling
  std::vector<double> weight_;      ///< barycentric
  std::vector<RangeTable> tables_;  ///< one a temperature
  double error_ = 0.0;
};

/// Temperatures in K become weighted radiance behind the path of each pixel's range, in place. Throws UsageError as
/// radiance_of_temperature and RangeTable::apply, before a pixel is changed. Returns TemperatureRangeTable::error.
double radiance_at_ranges(mtf::ImageView<float> temperature_k, mtf::ImageView<const float> range_m,
                          const SceneBand& scene, const SurfaceFinish& finish, const PathTable& table,
                          const PlaneOptions& options = {});

}  // namespace radiometry
