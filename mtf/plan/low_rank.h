// SPDX-License-Identifier: Apache-2.0
#pragma once

// A two-dimensional kernel as a sum of products of one-dimensional ones, best in the least-squares sense (singular
// value decomposition; Eckart and Young, Psychometrika 1, 211 (1936)).

#include <vector>

#include "mtf/plan/point_response.h"

namespace mtf {

/// value(r, c) = sum over k of along_y[k][r] x along_x[k][c], the largest terms first. Kernels that equal
/// their mirror images along both axes give terms that do so too, bit by bit.
struct SeparableTerms {
  std::vector<std::vector<double>> along_y, along_x;
};

/// The `most` largest terms.
SeparableTerms separable_terms(const TapBox& kernel, std::size_t most);

/// The kernel that the first `count` terms make.
TapBox product_of(const SeparableTerms& terms, std::size_t count);

}  // namespace mtf
