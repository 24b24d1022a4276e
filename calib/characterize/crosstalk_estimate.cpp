// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/crosstalk_estimate.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

constexpr double kSure_sd = 3.0;

double power_of(double s, double c) {
  const double h0 = 1.0 - 4.0 * s - 4.0 * c;
  return h0 * h0 + 4.0 * s * s + 4.0 * c * c;
}

/// The fractions that have those ratios of covariances.
std::array<double, 2> fractions_of(double side_ratio, double corner_ratio, bool with_corner) {
  double s = 0.5 * side_ratio, c = with_corner ? 0.5 * corner_ratio : 0.0;
  for (int i = 0; i < 200; ++i) {
    const double h0 = 1.0 - 4.0 * s - 4.0 * c, r00 = power_of(s, c);
    const double next_s = side_ratio * r00 / (2.0 * h0 + 4.0 * c);
    const double next_c = with_corner ? (corner_ratio * r00 - 2.0 * s * s) / (2.0 * h0) : 0.0;
    const bool still = std::abs(next_s - s) + std::abs(next_c - c) < 1e-15;
    // Half steps: the iteration contracts for all fractions that frames show.
    s = 0.5 * (s + next_s);
    c = 0.5 * (c + next_c);
    if (still) break;
  }
  return {s, c};
}

/// Mean of two estimates by their variances.
Estimate pooled(const Estimate& a, const Estimate& b) {
  const double wa = 1.0 / (a.sd * a.sd), wb = 1.0 / (b.sd * b.sd);
  return {(wa * a.value + wb * b.value) / (wa + wb), 1.0 / std::sqrt(wa + wb)};
}

}  // namespace

CrosstalkEstimate estimate_crosstalk(const std::vector<CorrelatedLevel>& levels) {
  CrosstalkEstimate result;
  for (std::size_t k = 0; k < kLags.size(); ++k) {
    const auto weight = [&](const CorrelatedLevel& level) {
      const double sd = level.covariance[k].sd;
      return sd > 0.0 ? 1.0 / (sd * sd) : 0.0;
    };
    double weights = 0.0, shot = 0.0, sum = 0.0, squares = 0.0;
    for (const CorrelatedLevel& level : levels) {
      weights += weight(level);
      shot += weight(level) * level.shot;
    }
    for (const CorrelatedLevel& level : levels) {
      const double above = level.shot - shot / weights;
      sum += weight(level) * above * level.covariance[k].value;
      squares += weight(level) * above * above;
    }
    if (!(squares > 0.0)) return result;
    result.ratio[k] = {sum / squares, 1.0 / std::sqrt(squares)};
  }
  const Estimate side = pooled(result.ratio[0], result.ratio[1]), corner = pooled(result.ratio[2], result.ratio[3]);
  constexpr double kMost_sd = 0.2;  // beyond, no fractions belong to a ratio that is as likely
  if (!(side.sd < kMost_sd)) return result;
  result.found = side.value > kSure_sd * side.sd;
  // A corner that is there beyond what two sides give it, 2 s^2 = r01^2 / 2.
  result.corner_found = result.found && corner.value - 0.5 * side.value * side.value > kSure_sd * corner.sd;
  const auto at = [&](double by_side, double by_corner) {
    return fractions_of(side.value + by_side * side.sd, corner.value + by_corner * corner.sd, result.corner_found);
  };
  const auto centre = at(0.0, 0.0);
  const auto spread = [&](auto value) {
    const double by_side = 0.5 * (value(at(1.0, 0.0)) - value(at(-1.0, 0.0)));
    const double by_corner = 0.5 * (value(at(0.0, 1.0)) - value(at(0.0, -1.0)));
    return Estimate{value(centre), std::hypot(by_side, by_corner)};
  };
  result.side = spread([](const auto& f) { return f[0]; });
  if (result.corner_found) result.corner = spread([](const auto& f) { return f[1]; });
  if (result.found) result.power = spread([](const auto& f) { return power_of(f[0], f[1]); });
  return result;
}

void undo_crosstalk(mtf::Image& plane, double side, double corner) {
  // x <- x + (measured - h x) converges as (1 - h)^n, h at its least over all frequencies.
  const double rate = std::max(8.0 * side, 4.0 * side + 8.0 * corner);
  constexpr double kMost = 0.9, kLeft = 1e-4;
  if (!(rate < kMost))
    throw mtf::UsageError("crosstalk of " + mtf::significant(side, 3) + " to each side and " +
                          mtf::significant(corner, 3) + " to each corner leaves too little of the finest pattern");
  const mtf::Image measured = plane.clone();
  const int steps = rate > 0.0 ? static_cast<int>(std::ceil(std::log(kLeft) / std::log(rate))) : 0;
  for (int step = 0; step < steps; ++step) {
    const mtf::Image before = plane.clone();
    const auto at = [&](std::int64_t x, std::int64_t y) {
      return static_cast<double>(before.at(std::clamp<std::int64_t>(x, 0, plane.width() - 1),
                                           std::clamp<std::int64_t>(y, 0, plane.height() - 1)));
    };
    for (std::int64_t y = 0; y < plane.height(); ++y)
      for (std::int64_t x = 0; x < plane.width(); ++x) {
        const double sides = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1);
        const double corners = at(x - 1, y - 1) + at(x + 1, y - 1) + at(x - 1, y + 1) + at(x + 1, y + 1);
        const double through = (1.0 - 4.0 * (side + corner)) * at(x, y) + side * sides + corner * corners;
        plane.at(x, y) = static_cast<float>(at(x, y) + static_cast<double>(measured.at(x, y)) - through);
      }
  }
}

}  // namespace calib
