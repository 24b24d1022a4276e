// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/defects/score_covariance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "calib/dense.h"
#include "mtf/math/clones.h"

namespace calib {
namespace {

// The bins at the distances of a pixel's neighbours, one a lag and direction; those beyond the pixels count as the
// outermost ones, as the lags' shares allow for neighbours that are missing.
struct Neighbour {
  double correlation;
  std::array<std::int16_t, kBins> bin;
};
struct Neighbourhood {
  int first = kBins, end = 0;  // bins that hold pixels
  std::vector<Neighbour> neighbours;
};
Neighbourhood neighbourhood_of(const FitState& state, Point normal) {
  const DistanceBins& bins = DistanceBins::get();
  Neighbourhood found;
  for (int b = 0; b < kBins; ++b)
    if (state.sums.count(b) > 0.0) found.first = std::min(found.first, b), found.end = b + 1;
  if (found.end == 0) return found;
  const double low = bins.centre(found.first), high = bins.centre(found.end - 1);
  for (const PixelLag& lag : state.correlation.lags)
    for (const double sign : {-1.0, 1.0}) {
      Neighbour& one =
          found.neighbours.emplace_back(Neighbour{state.correlation.margin * lag.correlation * lag.share, {}});
      const double away = sign * (normal.x * lag.x + normal.y * lag.y);
      for (int b = found.first; b < found.end; ++b)
        one.bin[static_cast<std::size_t>(b)] =
            static_cast<std::int16_t>(bins.index(std::clamp(bins.centre(b) + away, low, high)));
    }
  return found;
}

MTFKIT_CLONES double weighted_product(const double* a, const double* b, const double* c, int n) {
  constexpr int kLanes = 8;
  std::array<double, kLanes> sum{};
  int i = 0;
  for (; i + kLanes <= n; i += kLanes)
    for (int k = 0; k < kLanes; ++k) sum[static_cast<std::size_t>(k)] += a[i + k] * b[i + k] * c[i + k];
  for (; i < n; ++i) sum[0] += a[i] * b[i] * c[i];
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

}  // namespace

ScoreColumn score_column(const Basis& basis, const StepProfile& profile, int unknown) {
  ScoreColumn column{.power = basis_power(unknown)};
  const BinRow& row = basis.row(unknown);
  const auto first = static_cast<std::size_t>(is_bend(unknown) ? profile.bend_first : 0);
  const auto end = static_cast<std::size_t>(is_bend(unknown) ? profile.bend_end : kBins);
  for (std::size_t i = first; i < end; ++i) column.row[i] = basis.scale(unknown) * row[i];
  return column;
}

Eigen::MatrixXd score_covariance(const FitState& state, const EdgeModel& model, std::span<const ScoreColumn> columns) {
  const auto size = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  const Neighbourhood near = neighbourhood_of(state, model.curve.normal());
  const int count = near.end - near.first;
  if (count <= 0) return covariance;
  const auto first = static_cast<std::size_t>(near.first);
  BinRow weight_sd = variances(state.noise, state.profile);
  for (std::size_t i = 0; i < kBins; ++i) weight_sd[i] = state.weight[i] * std::sqrt(weight_sd[i]);
  std::vector<BinRow> rows(columns.size()), sums(columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (std::size_t i = 0; i < kBins; ++i) rows[j][i] = weight_sd[i] * columns[j].row[i];
    BinRow& sum = sums[j] = rows[j];
    for (const auto& [correlation, bin] : near.neighbours)
      for (auto i = first; i < static_cast<std::size_t>(near.end); ++i)
        sum[i] += correlation * rows[j][static_cast<std::size_t>(bin[i])];
  }
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const double* moment = state.sums.moment(columns[j].power + columns[k].power).data() + first;
      const double half = 0.5 * weighted_product(rows[j].data() + first, sums[k].data() + first, moment, count);
      covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) += half;
      covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)) += half;
    }
  return covariance;
}

Matrix score_covariance(const FitState& state, const EdgeModel& model, const Unknowns& unknowns) {
  if (state.correlation.white()) return state.normal.matrix;
  const Basis basis(state.profile, model.contrast(), unknowns);
  std::vector<int> list;
  std::vector<ScoreColumn> columns;
  for (int a = 0; a < kUnknowns; ++a)
    if (unknowns[static_cast<std::size_t>(a)]) {
      list.push_back(a);
      columns.push_back(score_column(basis, state.profile, a));
    }
  const Eigen::MatrixXd some = score_covariance(state, model, columns);
  Matrix all = Matrix::Zero();
  for (std::size_t j = 0; j < list.size(); ++j)
    for (std::size_t k = 0; k < list.size(); ++k)
      all(list[j], list[k]) = some(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k));
  return all;
}

Eigen::MatrixXd no_less_than(const Eigen::MatrixXd& least, const Eigen::MatrixXd& covariance) {
  constexpr double kRidge = 1e-11;
  const Eigen::VectorXd scale = least.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  Eigen::MatrixXd unit = inverse.asDiagonal() * least * inverse.asDiagonal();
  unit.diagonal().array() += kRidge;
  const Eigen::MatrixXd other = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const auto pairs = eigenpairs(other, unit);
  if (!pairs) return least;
  const Eigen::MatrixXd vectors = scale.asDiagonal() * unit * pairs->vectors;
  return vectors * pairs->values.cwiseMax(1.0).asDiagonal() * vectors.transpose();
}

}  // namespace calib
