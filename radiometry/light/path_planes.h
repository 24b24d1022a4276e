// SPDX-License-Identifier: Apache-2.0
#pragma once

// A path whose length differs from pixel to pixel: weighted radiance (scene_radiance.h, made with the camera's
// curves alone) times the transmission at the pixel's range, plus the radiance of the path, both from one PathTable.
//   tau(r) = sum w_j tau_j(r) / w,   w_j = integral of hat_j R S,   w = integral of R S
//   L(r)   = sum v_j L_j(r),         v_j = integral of hat_j R lambda/(hc), or of hat_j R in watts
// with hat_j, the straight lines between the wavelengths of the table, and S, the radiance of a blackbody of
// `source_k` or, without one, a constant. So tau(r) is exact for a scene of that spectrum, band and not Beer behaviour
// included; for a scene of other spectra or temperatures it is an approximation, since the spectrum of a pixel is no
// longer known here (temperature_paths.h takes scenes of temperatures). Between the ranges of the table tau_j and L_j
// follow PathTable; at range 0 the path is clear. tau is interpolated between nodes so dense that cubics through value
// and slope are right within 1e-7 (at most 4096 nodes between two ranges, fewer for more than 24000 wavelengths); the
// radiance of the path is exact.

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

}  // namespace radiometry
