// SPDX-License-Identifier: Apache-2.0
#pragma once

// Weights of the modes of a lens whose OTF has kinks over the field (cat's eye): polynomials over the image do not
// follow them. A mode p_k takes the weight
//   a_k(q) = sum over f of t_k(f) E_k(f; q),    E_k the part of the OTF that the mode is of,
// the projection on it, at any place q: E is a sum of tables along the radius, turned (field_tables.h), so that a_k is
// a sum of numbers known for each table and angle.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mtf/engines/fft/parity.h"
#include "mtf/field/field_tables.h"

namespace mtf {

/// The same for each mode: its part, and t_k at the frequencies.
struct Projection {
  OtfPart part;
  Eigen::VectorXd at;
};

/// a_k at the places: [place][k].
Eigen::MatrixXd radial_weights(const FieldTables& tables, std::span<const Freq<double>> f,
                               std::span<const Projection> modes, std::span<const FieldPoint<double>> places,
                               int threads);

}  // namespace mtf
