// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/low_rank.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace mtf {

SeparableTerms separable_terms(const TapBox& kernel, std::size_t most) {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Matrix matrix = Eigen::Map<const Matrix>(kernel.value.data(), kernel.rows, kernel.columns);
  const Eigen::BDCSVD<Matrix> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const double scale = matrix.cwiseAbs().maxCoeff();
  const bool mirrored = (matrix - matrix.rowwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale &&
                        (matrix - matrix.colwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale;
  // Rounding leaves mirror images that differ in the last bits; terms of odd symmetry come only from rounding.
  const auto even = [mirrored](std::vector<double> taps) {
    for (std::size_t i = 0; mirrored && 2 * i < taps.size(); ++i)
      taps[i] = taps[taps.size() - 1 - i] = 0.5 * (taps[i] + taps[taps.size() - 1 - i]);
    return taps;
  };
  SeparableTerms terms;
  const auto rank = std::min<std::size_t>(most, static_cast<std::size_t>(svd.singularValues().size()));
  for (std::size_t k = 0; k < rank; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double root = std::sqrt(svd.singularValues()(i));
    std::vector<double> y, x;
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) y.push_back(root * svd.matrixU()(r, i));
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) x.push_back(root * svd.matrixV()(c, i));
    terms.along_y.push_back(even(std::move(y)));
    terms.along_x.push_back(even(std::move(x)));
  }
  return terms;
}

TapBox product_of(const SeparableTerms& terms, std::size_t count) {
  TapBox box{static_cast<std::int64_t>(terms.along_y.front().size()),
             static_cast<std::int64_t>(terms.along_x.front().size()),
             {}};
  box.value.assign(static_cast<std::size_t>(box.rows * box.columns), 0.0);
  for (std::size_t k = 0; k < std::min(count, terms.along_y.size()); ++k)
    for (std::int64_t r = 0; r < box.rows; ++r)
      for (std::int64_t c = 0; c < box.columns; ++c)
        box.at(r, c) += terms.along_y[k][static_cast<std::size_t>(r)] * terms.along_x[k][static_cast<std::size_t>(c)];
  return box;
}

}  // namespace mtf
