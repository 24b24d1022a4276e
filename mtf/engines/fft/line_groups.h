// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which lines of a plane the spectral engine transforms. Lines go through the engine in groups of kRow, and this file
// alone decides for each group whether it takes a transform:
//   forwards   A line is uniform when all its samples are equal and its border continues them. Its canvas is then a
//              constant, which has one coefficient, and so takes no transform.
//   backwards  A filtered line that lies over uniform ones holds what the point spread carries there from elsewhere.
//              The tails of the OTF do not bound it well, but by Parseval the line's own coefficients tell it exactly:
//              the squares of all but the zeroth one are its variance. The groups with the least variance are
//              negligible, as many of them as the channel's allowance covers together, and they come out uniform.

#include <cstdint>
#include <span>
#include <vector>

#include "mtf/engines/engine.h"
#include "mtf/engines/fft/axis.h"

namespace mtf {

/// Numbers of groups of kRow lines, in rising order.
struct LineGroups {
  std::vector<std::int64_t> transformed;
  std::vector<std::int64_t> uniform;  ///< every line of the group is uniform, or comes out so
};

/// The groups of a channel's input. `x` is the axis along the lines, `y` the one across them.
LineGroups input_groups(const Channel& channel, Lines lines, const AxisTransform& x, const AxisTransform& y,
                        int threads);

/// The groups of the output that lie over uniform lines of the input. Any other has contrast of its own.
std::vector<std::int64_t> groups_over_uniform(const LineGroups& input, const AxisTransform& x, const AxisTransform& y);

/// The groups of the output. energies[i] is the sum of the squares of all coefficients but the zeroth ones in group
/// over_uniform[i]; `allowance` is the rms contrast over the output that may be left out.
LineGroups output_groups(std::span<const std::int64_t> over_uniform, std::span<const double> energies, double allowance,
                         const AxisTransform& x, const AxisTransform& y);

}  // namespace mtf
