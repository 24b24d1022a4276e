// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/trend.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/characterize/pattern.h"

namespace calib {
namespace {

constexpr int kMostPasses = 10;
constexpr std::int64_t kPixelsADegree = 8;

/// Of degrees 0 to n at `count` places: [degree][place], orthonormal.
std::vector<std::vector<double>> orthonormal(std::int64_t count, int n) {
  std::vector<std::vector<double>> p(static_cast<std::size_t>(n) + 1,
                                     std::vector<double>(static_cast<std::size_t>(count)));
  const double middle = 0.5 * static_cast<double>(count - 1);
  for (std::size_t k = 0; k < p.size(); ++k) {
    for (std::size_t i = 0; i < p[k].size(); ++i)
      p[k][i] = k == 0 ? 1.0 : p[k - 1][i] * (static_cast<double>(i) - middle) / middle;
    for (int twice = 0; twice < 2; ++twice)  // once loses digits
      for (std::size_t before = 0; before < k; ++before) {
        double product = 0.0;
        for (std::size_t i = 0; i < p[k].size(); ++i) product += p[k][i] * p[before][i];
        for (std::size_t i = 0; i < p[k].size(); ++i) p[k][i] -= product * p[before][i];
      }
    double square = 0.0;
    for (const double value : p[k]) square += value * value;
    for (double& value : p[k]) value /= std::sqrt(square);
  }
  return p;
}

}  // namespace

Trend remove_trend(mtf::ImageView<float> plane, int degree) {
  Trend trend;
  trend.degree = static_cast<int>(std::min<std::int64_t>(degree, std::min(plane.width, plane.height) / kPixelsADegree));
  if (trend.degree <= 0) return trend;
  const auto n = static_cast<std::size_t>(trend.degree);
  const auto along_x = orthonormal(plane.width, trend.degree), along_y = orthonormal(plane.height, trend.degree);
  std::vector<double> found((n + 1) * (n + 1), 0.0);  // [degree of y][of x]
  // Of pixels beyond the limit nothing is known: they take part as the trend has them, which passes settle.
  double far = INFINITY;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    std::vector<double> more(found.size(), 0.0), of_row(n + 1);
    for (std::int64_t y = 0; y < plane.height; ++y) {
      std::fill(of_row.begin(), of_row.end(), 0.0);
      for (std::int64_t x = 0; x < plane.width; ++x) {
        const auto value = static_cast<double>(plane.at(x, y));
        if (std::abs(value) > far) continue;
        for (std::size_t i = 0; i <= n; ++i) of_row[i] += value * along_x[i][static_cast<std::size_t>(x)];
      }
      for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i + j <= n; ++i)
          more[j * (n + 1) + i] += of_row[i] * along_y[j][static_cast<std::size_t>(y)];
    }
    double change = 0.0, size = 0.0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      found[k] += more[k];
      change = std::max(change, std::abs(more[k]));
      size = std::max(size, std::abs(found[k]));
    }
    for (std::int64_t y = 0; y < plane.height; ++y)
      for (std::int64_t x = 0; x < plane.width; ++x) {
        double value = 0.0;
        for (std::size_t j = 0; j <= n; ++j)
          for (std::size_t i = 0; i + j <= n; ++i)
            value += more[j * (n + 1) + i] * along_y[j][static_cast<std::size_t>(y)] *
                     along_x[i][static_cast<std::size_t>(x)];
        plane.at(x, y) -= static_cast<float>(value);
      }
    far = defect_limit(static_cast<std::size_t>(plane.width * plane.height), [&](std::size_t i) {
      const auto at = static_cast<std::int64_t>(i);
      return static_cast<double>(plane.at(at % plane.width, at / plane.width));
    });
    if (change <= 1e-6 * size) break;
  }
  const double mean = found[0] * along_x[0][0] * along_y[0][0];
  for (std::int64_t y = 0; y < plane.height; ++y)
    for (std::int64_t x = 0; x < plane.width; ++x) plane.at(x, y) += static_cast<float>(mean);
  for (std::size_t j = 0; j <= n; ++j)
    for (std::size_t i = 0; i + j <= n; ++i)
      if (i + j > 0)
        (i == 0 ? trend.rows : j == 0 ? trend.columns : trend.cross) += found[j * (n + 1) + i] * found[j * (n + 1) + i];
  return trend;
}

}  // namespace calib
