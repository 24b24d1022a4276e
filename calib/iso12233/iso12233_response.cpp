// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/dense.h"
#include "calib/iso12233/iso12233_parts.h"

namespace calib::iso {
namespace {

constexpr std::int64_t kBins = 4;         // a column
constexpr std::int64_t kSpareBins = 150;  // beyond those over which the edge drifts
constexpr double kMaxCorrection = 10.0;   // of the response of differences

/// Central differences; the ends repeat their neighbours.
std::vector<double> line_spread(const std::vector<double>& esf) {
  const std::size_t n = esf.size();
  std::vector<double> d(n);
  for (std::size_t i = 1; i + 1 < n; ++i) d[i] = 0.5 * (esf[i + 1] - esf[i - 1]);
  d[0] = d[1];
  d[n - 1] = d[n - 2];
  return d;
}

/// Shifted so that its maximum, the mean place of equal ones, is in the middle; zeros come in.
std::vector<double> centred(const std::vector<double>& d) {
  const auto n = static_cast<std::int64_t>(d.size());
  const double top = *std::max_element(d.begin(), d.end());
  double place = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < n; ++i)
    if (d[static_cast<std::size_t>(i)] == top) place += static_cast<double>(i + 1), count += 1.0;
  const std::int64_t middle = std::llround(0.5 * static_cast<double>(n + 1));
  const std::int64_t shift = std::llround(place / count - static_cast<double>(middle));
  std::vector<double> moved(d.size(), 0.0);
  for (std::int64_t i = std::max<std::int64_t>(0, -shift); i < std::min(n, n - shift); ++i)
    moved[static_cast<std::size_t>(i)] = d[static_cast<std::size_t>(i + shift)];
  return moved;
}

/// Response of central differences by the index of the sample, one step ahead of the frequency as in the reference.
double difference_correction(std::size_t k, std::size_t samples) {
  if (k == 0) return 1.0;
  const double x = std::numbers::pi * static_cast<double>(k + 1) / static_cast<double>(samples + 1);
  return std::min(std::abs(x / std::sin(x)), kMaxCorrection);
}

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

std::int64_t whole_cycles(std::int64_t rows, double slope) {
  const double pace = std::abs(slope);
  const double cycles = std::floor(static_cast<double>(rows) * pace);
  return cycles < 1.0 ? 0 : std::min<std::int64_t>(rows, std::llround(cycles / pace));
}

Profile project(const Region& region, std::int64_t rows, const RowPolynomial& curve) {
  const std::int64_t columns = region.columns(), bins = kBins * columns;
  const double drift = static_cast<double>(kBins * (rows - 1)) * curve.slope(0.0);
  if (!(std::abs(drift) <= 16.0 * static_cast<double>(kBins * (rows + columns)))) return {};
  const std::int64_t shift = std::abs(std::llround(drift));
  const std::int64_t offset = drift > 0.0 ? -shift : 0;
  const std::int64_t first = std::llround(0.5 * static_cast<double>(shift));
  const std::int64_t all = bins + shift + kSpareBins;

  std::vector<double> count(static_cast<std::size_t>(all), 0.0), sum(static_cast<std::size_t>(all), 0.0);
  for (std::int64_t row = 0; row < rows; ++row) {
    const double edge = curve(static_cast<double>(row)) - curve(0.0);
    for (std::int64_t column = 0; column < columns; ++column) {
      const double bin = std::ceil((static_cast<double>(column) - edge) * kBins) - static_cast<double>(offset);
      const auto k = static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(all - 1)));
      count[k] += 1.0;
      sum[k] += region.at(row, column);
    }
  }

  Profile profile;
  profile.esf.resize(static_cast<std::size_t>(bins));
  double last = std::numeric_limits<double>::quiet_NaN();
  for (std::int64_t i = 0; i < bins; ++i) {
    const auto k = static_cast<std::size_t>(first + i);
    if (count[k] == 0.0) {
      ++profile.empty_bins;
      // Halves of both neighbours' counts and sums; at the ends the one inside.
      const bool before = k > 0, after = i + 1 < bins || k == 0;
      const double share = before && after ? 0.5 : 1.0;
      count[k] = share * ((before ? count[k - 1] : 0.0) + (after ? count[k + 1] : 0.0));
      sum[k] = share * ((before ? sum[k - 1] : 0.0) + (after ? sum[k + 1] : 0.0));
    }
    // Runs of empty bins at the start have no neighbour yet; they take the first value below.
    if (count[k] > 0.0) last = sum[k] / count[k];
    profile.esf[static_cast<std::size_t>(i)] = last;
  }
  const auto known = std::find_if(profile.esf.begin(), profile.esf.end(), [](double v) { return std::isfinite(v); });
  if (known == profile.esf.end()) return {};
  std::fill(profile.esf.begin(), known, *known);
  return profile;
}

std::vector<double> response(const std::vector<double>& esf, bool tukey) {
  std::vector<double> lsf = centred(line_spread(esf));
  const auto n = static_cast<std::int64_t>(lsf.size());
  const double middle = 0.5 * static_cast<double>(n);
  const std::vector<double> window = tukey ? tukey_window(n, middle) : hamming_window(n, middle);
  for (std::size_t i = 0; i < lsf.size(); ++i) lsf[i] *= window[i];

  std::vector<double> cosine(lsf.size());
  for (std::size_t i = 0; i < cosine.size(); ++i)
    cosine[i] = std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
  const std::size_t half = lsf.size() / 2 + 1, quarter = lsf.size() / kBins;
  std::vector<double> sfr(quarter + 1);
  for (std::size_t k = 0; k < sfr.size(); ++k) {
    double re = 0.0, im = 0.0;
    // n is a multiple of 4: the sine is the cosine a quarter turn back.
    for (std::size_t i = 0, turn = 0; i < lsf.size(); ++i, turn = (turn + k) % lsf.size()) {
      re += lsf[i] * cosine[turn];
      im += lsf[i] * cosine[turn >= quarter ? turn - quarter : turn + 3 * quarter];
    }
    sfr[k] = std::hypot(re, im) * difference_correction(k, half);
  }
  const double total = sfr[0];
  if (!(total > 0.0)) return {};
  for (double& value : sfr) value /= total;
  return sfr;
}

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
