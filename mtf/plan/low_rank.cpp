// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/low_rank.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace mtf {

SeparableTerms separable_terms(const TapBox& kernel, std::size_t most) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> matrix(kernel.value.data(), kernel.rows, kernel.columns);
  // Filled up with zeros to a square, whose singular vectors only grow by zeros: a square needs no QR preconditioner,
  // and Eigen's preconditioners take half a minute to compile. Kernels are of 49 x 49 taps at most.
  const Eigen::Index size = std::max(matrix.rows(), matrix.cols());
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(size, size);
  square.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(square,
                                                                         Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double scale = matrix.cwiseAbs().maxCoeff();
  const bool mirrored = (matrix - matrix.rowwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale &&
                        (matrix - matrix.colwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale;
  // Rounding leaves mirror images that differ in their last bits, and only rounding makes terms of odd symmetry.
  const auto even = [mirrored](std::vector<double> taps) {
    for (std::size_t i = 0; mirrored && 2 * i < taps.size(); ++i)
      taps[i] = taps[taps.size() - 1 - i] = 0.5 * (taps[i] + taps[taps.size() - 1 - i]);
    return taps;
  };
  SeparableTerms terms;
  const auto rank = std::min<std::size_t>(most, static_cast<std::size_t>(std::min(matrix.rows(), matrix.cols())));
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
