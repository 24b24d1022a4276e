// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random numbers for kNoiseLanes pixels at a time, in plain loops over lanes that the compiler turns into vectors.
// Each lane depends on its own pixel alone, and no operation is contracted or reordered, so that the numbers are the
// same wherever a block begins and on every machine.

#include "radiometry/stages/noise/random.h"

namespace radiometry {

inline constexpr int kNoiseLanes = 128;

/// Standard normal numbers of the pixels 2 half_column ... 2 half_column + kNoiseLanes - 1: by the transform of Box and
/// Muller, the radius from 62 bits, so that the tails extend to 9.2 sigma, the angle from 32.
void gaussian_lanes(const RandomRow& row, std::uint32_t half_column, float* out);

/// Poisson numbers of the same pixels for the means given; see poisson.h.
void poisson_lanes(const RandomRow& row, std::uint32_t half_column, const float* mean, float* out);

}  // namespace radiometry
