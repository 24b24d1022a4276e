// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/tile_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/field/chebyshev.h"
#include "mtf/math/barycentric.h"

namespace mtf {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Eigen::Index;

constexpr std::size_t kTerms = TileModes::kTerms;
constexpr std::size_t kLooked = 2 * kTerms - 1;  // places along an axis: the points of the polynomials, and between
constexpr double kBetweenPlaces = 1.02;

/// Places of a tile's pixels, from -1 at the centre of the first to 1 at that of the last.
double place_in_tile(std::int64_t pixel, std::int64_t count) {
  return count > 1 ? 2.0 * static_cast<double>(pixel) / static_cast<double>(count - 1) - 1.0 : 0.0;
}

/// [point of the tile][term of the image].
Matrix image_terms(const FieldModes& field, std::int64_t first, std::int64_t count, bool along_x,
                   const std::vector<double>& points) {
  Matrix terms(static_cast<Index>(points.size()), static_cast<Index>(field.terms()));
  for (Index i = 0; i < terms.rows(); ++i) {
    const double pixel =
        static_cast<double>(first) + 0.5 * (1.0 + points[static_cast<std::size_t>(i)]) * static_cast<double>(count - 1);
    const std::vector<double> values = chebyshev(field.terms(), along_x ? field.place_x(pixel) : field.place_y(pixel));
    terms.row(i) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), terms.cols());
  }
  return terms;
}

/// What the polynomials through values at the points are at the places that are looked at: [place][point].
Matrix between_points(const std::vector<double>& looked) {
  const Barycentric points = Barycentric::with_ends(kTerms);
  Matrix to(kLooked, kTerms);
  std::vector<double> weights(kTerms);
  for (Index i = 0; i < to.rows(); ++i) {
    points.weights_at(looked[static_cast<std::size_t>(i)], weights.data());
    to.row(i) = Eigen::Map<const Eigen::RowVectorXd>(weights.data(), to.cols());
  }
  return to;
}

}  // namespace

std::vector<float> tile_terms(std::int64_t width) {
  const auto count = static_cast<std::size_t>(width);
  std::vector<float> terms(kTerms * count);
  for (std::size_t x = 0; x < count; ++x) {
    const std::vector<double> values = chebyshev(kTerms, place_in_tile(static_cast<std::int64_t>(x), width));
    for (std::size_t i = 0; i < kTerms; ++i) terms[i * count + x] = static_cast<float>(values[i]);
  }
  return terms;
}

std::optional<TileModes> tile_modes(const FieldModes& field, const FieldModes::Measure& measure, const Region& region,
                                    double allowed, std::size_t most) {
  const auto all = static_cast<Index>(field.count()), n = static_cast<Index>(field.terms());
  const std::vector<double> points = Barycentric::with_ends(kTerms).x, looked = Barycentric::with_ends(kLooked).x;
  const Matrix x = image_terms(field, region.x, region.width, true, looked),
               y = image_terms(field, region.y, region.height, false, looked);
  // scale_m a_m at the places [x + kLooked y][m].
  Matrix left(static_cast<Index>(kLooked * kLooked), all);
  for (Index m = 0; m < all; ++m) {
    const double scale = measure.scale[static_cast<std::size_t>(m)];
    const Matrix here =
        x * Eigen::Map<const Matrix>(field.series(static_cast<std::size_t>(m) + 1).data(), n, n) * y.transpose();
    left.col(m) = scale * Eigen::Map<const Vector>(here.data(), here.size());
  }
  const Matrix given = left;
  // Singular vectors over the points, which are every other place.
  const std::vector<double> share = mean_weights(kTerms);
  constexpr auto kPoints = static_cast<Index>(kTerms * kTerms);
  Matrix at_points(kPoints, all);
  Vector root(kPoints);
  for (std::size_t j = 0; j < kTerms; ++j)
    for (std::size_t i = 0; i < kTerms; ++i) {
      const auto k = static_cast<Index>(j * kTerms + i);
      root(k) = std::sqrt(share[i] * share[j]);
      at_points.row(k) = left.row(static_cast<Index>(2 * j * kLooked + 2 * i));
    }
  const Matrix weighted = root.asDiagonal() * at_points;
  Matrix gram = Matrix::Zero(kPoints, kPoints);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(gram);
  const Matrix between = between_points(looked), series = to_series(kTerms);

  TileModes tile;
  tile.region = region;
  const auto bound = [&] { return kBetweenPlaces * measure.rms * std::sqrt(left.rowwise().squaredNorm().maxCoeff()); };
  for (tile.error = bound(); tile.error > allowed; tile.error = bound(), ++tile.count) {
    const Index k = kPoints - 1 - static_cast<Index>(tile.count);
    if (tile.count == most || k < 0 || !(solver.eigenvalues()(k) > 0.0)) return std::nullopt;
    const Vector direction = (weighted.transpose() * solver.eigenvectors().col(k)).normalized();
    const Vector values = at_points * direction;  // of the weight at the points
    const Eigen::Map<const Matrix> grid(values.data(), static_cast<Index>(kTerms), static_cast<Index>(kTerms));
    const Matrix everywhere = between * grid * between.transpose();
    left -= Eigen::Map<const Vector>(everywhere.data(), everywhere.size()) * direction.transpose();
    const double largest = kBetweenPlaces * std::max(everywhere.cwiseAbs().maxCoeff(), 1e-300);
    for (Index m = 0; m < all; ++m)
      tile.mix.push_back(largest * direction(m) / measure.scale[static_cast<std::size_t>(m)]);
    const Matrix coefficients = series * grid * series.transpose() / largest;
    for (std::int64_t row = 0; row < region.height; ++row) {
      const std::vector<double> along = chebyshev(kTerms, place_in_tile(row, region.height));
      const Vector terms = coefficients * Eigen::Map<const Vector>(along.data(), static_cast<Index>(kTerms));
      for (const double term : terms) tile.rows.push_back(static_cast<float>(term));
    }
  }
  for (Index m = 0; m < all; ++m)
    tile.amount.push_back(kBetweenPlaces * (given.col(m) - left.col(m)).cwiseAbs().maxCoeff() /
                          measure.scale[static_cast<std::size_t>(m)]);
  return tile;
}

}  // namespace mtf
