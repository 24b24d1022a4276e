// SPDX-License-Identifier: Apache-2.0
#pragma once

// A path whose length differs from pixel to pixel: weighted radiance (scene_radiance.h, made with the camera's
// curves alone) times the transmission at the pixel's range, plus the radiance of the path, both from one PathTable.
//   tau(r) = sum w_j tau_j(r) / w,   w_j = integral of hat_j R S,   w = integral of R S
//   L(r)   = sum v_j L_j(r),         v_j = integral of hat_j R lambda/(hc), or of hat_j R in watts
// with hat_j, the straight lines between the wavelengths of the table, and S, the radiance of a blackbody of
// `source_k` or, without one, a constant. So tau(r) is exact for a scene of that spectrum, band and not Beer behaviour
// included; for a scene of other spectra or temperatures it is an approximation, since the spectrum of a pixel is no
// longer known there (TemperatureRangeTable takes scenes of temperatures). Between the ranges of the table tau_j and
// L_j follow PathTable; at range 0 the path is clear. tau is interpolated between nodes so dense that cubics through
// value and slope are right within 1e-7 (at most 4096 nodes between two ranges, fewer for more than 24000 wavelengths);
// the radiance of the path is exact.

#include <optional>
#include <string>
#include <vector>

#include "mtf/image.h"
#include "radiometry/light/scene_radiance.h"

namespace radiometry {

/// Throws UsageError for ranges, in m, that are not above 0 or lie beyond the table, with their number and the first.
void require_ranges(mtf::ImageView<const float> range_m, const PathTable& table, int threads = 1);

class RangeTable {
 public:
  /// Throws UsageError when the table, the band and the curves have no wavelengths in common, and when a scene of that
  /// spectrum gives nothing.
  RangeTable(const SceneBand& scene, const PathTable& table, std::optional<double> source_k);

  double longest_m() const { return range_m_.back(); }
  /// The transmission at a range in [0, longest]. Throws UsageError for other ranges.
  double transmission(double range_m) const;
  double radiance(double range_m) const;  ///< weighted

  /// radiance = transmission x radiance + path, pixel by pixel. Ranges are in m, above 0 and not beyond the table.
  /// Throws UsageError for others, with the number of pixels and the first one, and for a plane of another size; then
  /// no pixel has been changed.
  void apply(mtf::ImageView<float> radiance, mtf::ImageView<const float> range_m, int threads = 1) const;

 private:
  struct Cell {
    double c0, c1, c2, c3;  ///< transmission, by the place in the cell
  };
  struct Segment {
    double from_m, cells_per_m, radiance, radiance_per_m;
    std::size_t first, count;  ///< cells
  };
  const Segment& segment(double range_m) const;
  const Segment& checked(double range_m) const;
  double transmission(const Segment& segment, double range_m) const;

  std::string source_;
  std::vector<double> range_m_;  ///< ends of the segments
  std::vector<Segment> segments_;
  std::vector<Cell> cells_;
};

// A scene of temperatures through a path whose length differs from pixel to pixel. Each surface has the spectrum of its
// own temperature, and a path takes more of one spectrum than of another: the band integral of emission x path is
//   L(T, r) = E(T) tau(T, r) + E'(Ts) tau'(Ts, r) + path(r),
//   E(T) = integral of R eps B(T),   tau(T, r) = (integral of R eps B(T) tau(r)) / E(T),
// E' and tau' the same with 1 - eps, R the camera's curves (scene_radiance.h), Ts what the surfaces reflect. tau(T, r)
// by range is the RangeTable of a source of temperature T; between temperatures it is the polynomial of
// 1/T through Chebyshev points of the scene's temperatures, 3, 5, 9 or 17 of them, until twice as many change tau E
// by less than 1e-7 of the hottest E.

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
