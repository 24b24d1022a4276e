// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defocus by range. A lens of focal length F and diameter D that is focused at the range f images what is at the range
// r, both along the optical axis, in a plane that lies
//   distance = F^2 (1/r - 1/f),    W020 = distance / (8 N^2 lambda) = D^2 / (8 lambda) (1/r - 1/f)
// from the image plane (thin lens; r and f beyond F, and much longer where N and F are those of infinity). Scenes give
// ranges Z along the ray of each sample, as `mtf render` writes them, so r = Z F / sqrt(F^2 + x^2 + y^2) where that ray
// meets the image plane at (x, y) from the optical axis; infinite Z is sky.
//
// Range belongs to the sample, not to the pixel: with h(x; r) the point spread and s the scene
//   out(x) = sum over u of h(x - u; r(u)) s(u) / sum over u of h(x - u; r(u)).
// The division keeps uniform scenes uniform. Light of surfaces that others hide is not in a scene.

#include <optional>
#include <string_view>
#include <vector>

#include "mtf/grid.h"
#include "mtf/image.h"
#include "mtf/system.h"

namespace mtf {

/// The presample component that is out of focus by the range of samples (defocus with focus), by its number.
std::optional<std::size_t> entry_by_range(const System<double>& system);
/// Throws UsageError where there is one: "`what` takes ...".
void refuse_range(const System<double>& system, std::string_view what);

/// Reciprocals of ranges along the optical axis.
struct SampleRanges {
  std::vector<double> per_m;  ///< of each sample, row by row; 0: sky
  double least = 0.0, most = 0.0, mean = 0.0;
};

/// Of a system with entry_by_range(). `range_m`: of the samples of `in`, seen by the detector `out`. Throws UsageError
/// for another size, and for a range that is within F or NaN, with their number and the first of them.
SampleRanges sample_ranges(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                           ImageView<const float> range_m);

/// The distance of the image plane at such a range.
double distance_at_um(const System<double>& system, double per_m);
/// The system that sees everything at that distance of the image plane.
System<double> with_distance(System<double> system, double distance_um);

}  // namespace mtf
