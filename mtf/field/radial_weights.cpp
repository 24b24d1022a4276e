// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/radial_weights.h"

#include <algorithm>
#include <cmath>

#include "mtf/field/weight_axis.h"
#include "mtf/math/special.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

using Matrix = Eigen::MatrixXd;
using Eigen::Index;

constexpr Index kFinerAngles = 8;  // angles to each at which tables are looked at: cubics between them err by 1e-5 of
                                   // the highest order and less of others

/// From values at n even angles about the circle to kFinerAngles n: the trigonometric polynomial through them.
Matrix finer_angles(Index n) {
  Matrix to(kFinerAngles * n, n);
  for (Index i = 0; i < to.rows(); ++i)
    for (Index j = 0; j < n; ++j) {
      const double away = kPi * (static_cast<double>(i) / static_cast<double>(kFinerAngles) - static_cast<double>(j));
      const double turn = std::tan(away / static_cast<double>(n));  // Dirichlet's kernel of an even number
      to(i, j) = i == kFinerAngles * j   ? 1.0
                 : i % kFinerAngles == 0 ? 0.0
                                         : std::sin(away) / (static_cast<double>(n) * turn);
    }
  return to;
}

}  // namespace

Matrix radial_weights(const FieldTables& tables, std::span<const Freq<double>> f, std::span<const Projection> modes,
                      std::span<const FieldPoint<double>> places, int threads) {
  const std::span<const PolarTable> along = tables.along_radius();
  std::size_t orders = 0;
  for (const PolarTable& table : along) orders = std::max(orders, table.orders());
  const auto angles = static_cast<Index>(2 * orders), count = static_cast<Index>(f.size());
  std::array<Matrix, 4> take;  // [mode][f] of each part
  for (Matrix& of_part : take) of_part = Matrix::Zero(static_cast<Index>(modes.size()), count);
  for (std::size_t k = 0; k < modes.size(); ++k)
    for (std::size_t p = 0; p < take.size(); ++p)
      if (modes[k].part == kOtfParts[p]) take[p].row(static_cast<Index>(k)) = modes[k].at.transpose();
  // [mode][angle] of each table, which is turned as the field point is.
  const Matrix finer = finer_angles(angles);
  std::vector<Matrix> turned(along.size());
  parallel_for_each(std::ssize(along), 1, threads, [&](std::int64_t i) {
    const PolarTable& table = along[static_cast<std::size_t>(i)];
    std::array<Matrix, 4> parts;
    for (Matrix& part : parts) part.resize(count, angles);
    for (Index j = 0; j < angles; ++j) {
      const double a = 2.0 * static_cast<double>(j) / static_cast<double>(angles), c = cos_pi(a), s = sin_pi(a);
      for (Index k = 0; k < count; ++k) {
        const Freq<double>& at = f[static_cast<std::size_t>(k)];
        const Complex<double> here = table.at({c * at.x + s * at.y, c * at.y - s * at.x}),
                              mirrored = table.at({c * at.x - s * at.y, -c * at.y - s * at.x});  // at (x, -y)
        parts[0](k, j) = 0.5 * (here.re + mirrored.re), parts[3](k, j) = 0.5 * (here.re - mirrored.re);
        parts[1](k, j) = 0.5 * (here.im - mirrored.im), parts[2](k, j) = 0.5 * (here.im + mirrored.im);
      }
    }
    Matrix sum = Matrix::Zero(static_cast<Index>(modes.size()), angles);
    for (std::size_t p = 0; p < take.size(); ++p) sum.noalias() += take[p] * parts[p];
    turned[static_cast<std::size_t>(i)] = sum * finer.transpose();
  });
  Matrix weights(static_cast<Index>(modes.size()), static_cast<Index>(places.size()));
  parallel_for_each(std::ssize(places), 256, threads, [&](std::int64_t i) {
    const FieldPoint<double>& q = places[static_cast<std::size_t>(i)];
    const Index all = kFinerAngles * angles;
    const double position = (std::atan2(q.y, q.x) / (2.0 * kPi) + 1.0) * static_cast<double>(all);
    const auto first = static_cast<Index>(position);
    const std::array<double, 4> cubic = cubic_weights(position - static_cast<double>(first));
    auto sum = weights.col(i);
    sum.setZero();
    for (const auto& [table, share] : tables.shares_at(std::hypot(q.x, q.y)))
      for (Index k = 0; k < 4; ++k)
        sum += share * cubic[static_cast<std::size_t>(k)] * turned[table].col((first + k - 1) % all);
  });
  return weights.transpose();
}

}  // namespace mtf
