// SPDX-License-Identifier: Apache-2.0
#pragma once

// Points of the unit interval for samples of designs, each a function of its number alone, whatever was drawn before:
// any order, any share of the designs and any number of threads see the same ones, and no memory grows with them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace study {

/// What random numbers of a study are for: last word of the Philox counter (radiometry/stages/noise/random.h) under the
/// study's seed. The values are part of the meaning of a seed: they never change.
enum class Purpose : std::uint32_t {
  permutation = 1001,
  stratum = 1002,
  sobol_shift = 1003,
  as_built = 1004,   ///< counter: draw, parameter
  indices = 1005,    ///< points of variance-based indices: sample, axis, set
  bootstrap = 1006,  ///< draws for their standard errors: sample, repetition
};

/// The place of `i` in a pseudo-random permutation of 0 ... n - 1, one for each axis and seed: a Feistel network over
/// the smallest power of two that holds n, walked along its cycle until it is back below n (Black and Rogaway, CT-RSA
/// 2002). i < n.
std::uint64_t permuted(std::uint64_t i, std::uint64_t n, std::uint32_t axis, std::uint64_t seed);

/// Latin hypercube (McKay, Beckman and Conover, Technometrics 21, 1979): each of n strata of an axis has one of the n
/// points, uniform in it. Inside (0, 1).
double latin_hypercube(std::uint64_t i, std::uint64_t n, std::uint32_t axis, std::uint64_t seed);

/// Direction numbers of one axis of Sobol's sequence in binary fractions of 32 bits, those of Joe and Kuo (SIAM J. Sci.
/// Comput. 30, 2008). They are enough for 2^31 points.
using SobolAxis = std::array<std::uint32_t, 31>;
/// There are at most 1000 axes.
std::vector<SobolAxis> sobol_axes(std::size_t axes);

/// Point i of the sequence in 32-bit fractions, in the order of Antonov and Saleev; point 0 is 0.
std::uint32_t sobol_bits(const SobolAxis& axis, std::uint64_t i);

/// The point with a digital shift of seed and axis, which keeps what makes the sequence uniform and takes it off the
/// corner 0. Inside (0, 1).
double sobol(const SobolAxis& directions, std::uint64_t i, std::uint32_t axis, std::uint64_t seed);

}  // namespace study
