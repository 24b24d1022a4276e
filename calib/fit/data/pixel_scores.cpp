// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/data/pixel_scores.h"

namespace calib {

Eigen::MatrixXd score_covariance(const PixelRows& rows, std::span<const PixelPlace> places,
                                 const NoiseCorrelation& noise) {
  const auto jacobian = rows.jacobian();
  // Of each pixel: the rows of its neighbours in one half plane, times their correlations.
  PixelRows::Matrix shared = PixelRows::Matrix::Zero(jacobian.rows(), jacobian.cols());
  for (const PixelLag& lag : noise.lags) {
    const double correlation = noise.margin * lag.correlation;
    std::size_t other = 0;  // the places at a lag are in the order of the pixels
    for (std::size_t p = 0; p < places.size(); ++p) {
      const auto before = [&](PixelPlace place) {
        const std::int32_t y = places[p].y + lag.y, x = places[p].x + lag.x;
        return place.y < y || (place.y == y && place.x < x);
      };
      while (other < places.size() && before(places[other])) ++other;
      if (other == places.size()) break;
      if (places[other].x != places[p].x + lag.x || places[other].y != places[p].y + lag.y) continue;
      shared.row(static_cast<Eigen::Index>(p)) += correlation * jacobian.row(static_cast<Eigen::Index>(other));
    }
  }
  const Eigen::MatrixXd half = jacobian.transpose() * shared;
  return jacobian.transpose() * jacobian + half + half.transpose();
}

}  // namespace calib
