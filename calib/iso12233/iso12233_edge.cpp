// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/dense.h"
#include "calib/iso12233/iso12233_parts.h"

namespace calib::iso {
namespace {

/// The Tukey window over a row's differences never falls below this, so that an edge far from the first guess counts.
constexpr double kWindowFloor = 0.05;

std::vector<double> edge_window(std::int64_t n, double centre, bool tukey) {
  if (!tukey) return hamming_window(n, centre);
  std::vector<double> window = tukey_window(n, centre);
  for (double& w : window) w = (1.0 - kWindowFloor) * w + kWindowFloor;
  return window;
}

/// Differences of neighbours in a row. The reference repeats the second and the last but one at the ends.
void differences(const Region& region, std::int64_t row, std::vector<double>& d) {
  const std::size_t n = d.size();
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const auto column = static_cast<std::int64_t>(i);
    d[i] = region.at(row, column + 1) - region.at(row, column);
  }
  d[0] = d[1];
  d[n - 1] = d[n - 2];
}

double centroid(const std::vector<double>& d, const std::vector<double>& window) {
  double sum = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    sum += window[i] * d[i];
    moment += window[i] * d[i] * static_cast<double>(i);
  }
  return moment / sum + 0.5;
}

double mean_of_row(const Region& region, std::int64_t row) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < region.columns(); ++i) sum += region.at(row, i);
  return sum / static_cast<double>(region.columns());
}

double mean_of_column(const Region& region, std::int64_t column) {
  double sum = 0.0;
  for (std::int64_t i = 0; i < region.rows(); ++i) sum += region.at(i, column);
  return sum / static_cast<double>(region.rows());
}

}  // namespace

std::vector<double> tukey_window(std::int64_t n, double centre) {
  const double count = static_cast<double>(n);
  const auto length = static_cast<std::int64_t>(std::llround(2.0 * std::max(centre, count - centre)));
  const std::int64_t skip = centre >= 0.5 * count ? 0 : length - n;
  std::vector<double> window(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i) {
    const std::int64_t from_end = std::min(skip + i, length - 1 - skip - i);
    window[static_cast<std::size_t>(i)] =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(from_end) / static_cast<double>(length - 1));
  }
  return window;
}

std::vector<double> hamming_window(std::int64_t n, double centre) {
  const double middle = centre + 0.5;
  const double side = std::max(middle - 1.0, static_cast<double>(n) - middle);
  std::vector<double> window(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i)
    window[static_cast<std::size_t>(i)] =
        0.54 + 0.46 * std::cos(std::numbers::pi * (static_cast<double>(i + 1) - middle) / side);
  return window;
}

Region turn_upright(mtf::ImageView<const float> image, const Roi& roi) {
  const Region upright{image, roi, false};
  const double down = mean_of_row(upright, roi.height - 4) - mean_of_row(upright, 2);
  const double across = mean_of_column(upright, roi.width - 4) - mean_of_column(upright, 2);
  return {image, roi, std::abs(down) > std::abs(across)};
}

RowPolynomial::RowPolynomial(const std::vector<double>& column, int order) {
  const double n = static_cast<double>(column.size());
  mean_ = 0.5 * (n - 1.0);
  sd_ = std::sqrt(n * (n + 1.0) / 12.0);
  Eigen::MatrixXd powers(column.size(), order + 1);
  for (Eigen::Index i = 0; i < powers.rows(); ++i) {
    double power = 1.0;
    for (Eigen::Index k = 0; k <= order; ++k, power *= (static_cast<double>(i) - mean_) / sd_) powers(i, k) = power;
  }
  const Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(column.data(), powers.rows());
  const Eigen::VectorXd solution = least_squares(powers, positions);
  std::copy(solution.begin(), solution.end(), coefficient_.begin());
}

double RowPolynomial::operator()(double row) const {
  const double z = (row - mean_) / sd_;
  double value = 0.0;
  for (std::size_t k = coefficient_.size(); k-- > 0;) value = value * z + coefficient_[k];
  return value;
}

double RowPolynomial::slope(double row) const {
  const double z = (row - mean_) / sd_;
  double value = 0.0;
  for (std::size_t k = coefficient_.size(); k-- > 1;) value = value * z + static_cast<double>(k) * coefficient_[k];
  return value / sd_;
}

EdgeFit fit_edge(const Region& region, int order, bool tukey) {
  const std::int64_t rows = region.rows(), columns = region.columns();
  std::vector<double> position(static_cast<std::size_t>(rows)), d(static_cast<std::size_t>(columns));
  EdgeFit fit;
  fit.rms_px = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> middle = edge_window(columns, 0.5 * static_cast<double>(columns + 1), tukey);
  for (const bool first : {true, false}) {
    for (std::int64_t row = 0; row < rows; ++row) {
      differences(region, row, d);
      // A curve that left the region has no window there; the middle one keeps its length bounded.
      const double centre = fit.curve(static_cast<double>(row));
      const bool inside = centre >= 0.0 && centre <= static_cast<double>(columns);
      double& at = position[static_cast<std::size_t>(row)];
      at = centroid(d, first || !inside ? middle : edge_window(columns, centre, tukey));
      if (!std::isfinite(at)) return fit;
    }
    fit.curve = RowPolynomial(position, order);
  }
  fit.line = RowPolynomial(position, 1);
  double squares = 0.0;
  for (std::int64_t row = 0; row < rows; ++row) {
    const double deviation = position[static_cast<std::size_t>(row)] - fit.curve(static_cast<double>(row));
    squares += deviation * deviation;
  }
  fit.rms_px = std::sqrt(squares / static_cast<double>(rows));
  return fit;
}

}  // namespace calib::iso
