// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/edge/median.h"
#include "mtf/engines/statistics.h"
#include "mtf/words.h"

namespace calib {
namespace {

constexpr double kFar_sd = 4.5;
constexpr double kMadToSd = 1.482602218505602;
constexpr int kPasses = 8;  // with pixels that do not count

using radiometry::kTh, radiometry::kTv, radiometry::kTvh;

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Means of rows and columns of the pixels that count; the columns are about the mean. By alternation, which is exact
/// at once where all count, and to a part in 1e12 with the few that do not.
struct Lines {
  std::vector<double> rows, columns;
};

Lines lines_of(mtf::ImageView<const float> plane, const std::vector<char>& out) {
  const auto V = static_cast<std::size_t>(plane.height), H = static_cast<std::size_t>(plane.width);
  Lines lines{std::vector<double>(V, 0.0), std::vector<double>(H, 0.0)};
  const auto average = [&](bool by_row) {
    std::vector<double>& mine = by_row ? lines.rows : lines.columns;
    std::vector<double> sum(mine.size(), 0.0), count(mine.size(), 0.0);
    for (std::size_t y = 0, i = 0; y < V; ++y)
      for (std::size_t x = 0; x < H; ++x, ++i) {
        if (out[i] != 0) continue;
        const auto value = static_cast<double>(plane.row(static_cast<std::int64_t>(y))[x]);
        sum[by_row ? y : x] += value - (by_row ? lines.columns[x] : lines.rows[y]);
        count[by_row ? y : x] += 1.0;
      }
    const double counted = mean_of(count), others = counted > 0.0 ? mean_of(sum) / counted : 0.0;  // of empty lines
    for (std::size_t k = 0; k < mine.size(); ++k) mine[k] = count[k] > 0.0 ? sum[k] / count[k] : others;
  };
  const bool all = std::find(out.begin(), out.end(), 1) == out.end();
  for (int pass = 0; pass < (all ? 1 : kPasses); ++pass) {
    average(true);
    average(false);
  }
  const double mean = mean_of(lines.columns);
  for (double& one : lines.columns) one -= mean;
  for (double& one : lines.rows) one += mean;
  return lines;
}

/// Medians of rows, and of what columns have beyond them, which single pixels do not move.
Lines median_lines(mtf::ImageView<const float> plane) {
  Lines lines;
  std::vector<double> values;
  for (std::int64_t y = 0; y < plane.height; ++y) {
    values.assign(plane.row(y), plane.row(y) + plane.width);
    lines.rows.push_back(median(values));
  }
  for (std::int64_t x = 0; x < plane.width; ++x) {
    values.clear();
    for (std::int64_t y = 0; y < plane.height; ++y)
      values.push_back(static_cast<double>(plane.row(y)[x]) - lines.rows[static_cast<std::size_t>(y)]);
    lines.columns.push_back(median(values));
  }
  return lines;
}

double residual(mtf::ImageView<const float> plane, const Lines& lines, std::size_t i) {
  const auto H = static_cast<std::size_t>(plane.width);
  return static_cast<double>(plane.row(static_cast<std::int64_t>(i / H))[i % H]) - lines.rows[i / H] -
         lines.columns[i % H];
}

/// Pixels so far off that they alone would move the means of their row and column by a tenth of what makes a defect,
/// as those that stand at an end of the scale. More than a hundredth of all are a group, and no such pixels.
std::vector<char> gross_pixels(mtf::ImageView<const float> plane) {
  constexpr double kMoves = 0.1;
  constexpr std::size_t kOneOf = 100;
  const auto n = static_cast<std::size_t>(plane.width * plane.height);
  const Lines lines = median_lines(plane);
  const double far = defect_limit(n, [&](std::size_t i) { return residual(plane, lines, i); }),
               most = kMoves * far * static_cast<double>(std::min(plane.width, plane.height));
  std::vector<char> gross(n, 0);
  for (std::size_t i = 0; i < n; ++i) gross[i] = far > 0.0 && std::abs(residual(plane, lines, i)) > most ? 1 : 0;
  if (static_cast<std::size_t>(std::ranges::count(gross, 1)) > n / kOneOf) std::ranges::fill(gross, 0);
  return gross;
}

/// Variance of a standard normal cut at +- kFar_sd.
double cut_variance() {
  const double density = std::exp(-0.5 * kFar_sd * kFar_sd) / std::sqrt(2.0 * std::numbers::pi);
  return 1.0 - 2.0 * kFar_sd * density / (1.0 - std::erfc(kFar_sd / std::numbers::sqrt2));
}

constexpr int kTrendPasses = 10;
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

double defect_limit(std::size_t count, const std::function<double(std::size_t)>& number) {
  const std::size_t stride = count / 1'000'000 + 1;
  std::vector<double> sizes;
  for (std::size_t i = 0; i < count; i += stride) sizes.push_back(std::abs(number(i)));
  return kFar_sd * kMadToSd * median(sizes);
}

PlaneSquares plane_squares(mtf::ImageView<const float> plane, int trend, const std::set<std::int64_t>& without) {
  const auto n = static_cast<std::size_t>(plane.width * plane.height), H = static_cast<std::size_t>(plane.width);
  std::vector<char> out(n, 0);
  for (const std::int64_t place : without)
    if (place >= 0 && place < std::ssize(out)) out[static_cast<std::size_t>(place)] = 1;
  const std::vector<char> given = out;
  const std::vector<char> gross = gross_pixels(plane);
  for (std::size_t i = 0; i < n; ++i) out[i] = std::max(out[i], gross[i]);
  Lines lines = lines_of(plane, out);
  auto left_out = static_cast<std::size_t>(std::ranges::count(out, 1));
  PlaneSquares result;
  for (int pass = 0; pass < 3; ++pass) {
    const double far = result.far = defect_limit(n, [&](std::size_t i) { return residual(plane, lines, i); });
    std::size_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
      out[i] = given[i] != 0 || (far > 0.0 && std::abs(residual(plane, lines, i)) > far) ? 1 : 0;
      count += static_cast<std::size_t>(out[i]);
    }
    if (count == left_out) break;
    left_out = count;
    lines = lines_of(plane, out);
  }
  result.rows = static_cast<double>(plane.height);
  result.columns = static_cast<double>(plane.width);
  double squares = 0.0, cubes = 0.0, fourths = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = residual(plane, lines, i), r2 = r * r;
    if (out[i] == 0)
      squares += r2, cubes += r2 * r, fourths += r2 * r2;
    else if (std::abs(r) > result.far)
      result.defects.push_back({static_cast<std::int64_t>(i % H), static_cast<std::int64_t>(i / H), r});
  }
  const double V = result.rows, W = result.columns;
  result.row_dof = V - 1.0 - trend;
  result.column_dof = W - 1.0 - trend;
  result.pixel_dof = (V - 1.0) * (W - 1.0) - static_cast<double>(left_out) - 0.5 * trend * (trend - 1);
  result.pixel = squares / result.pixel_dof / cut_variance();
  const double mean = mean_of(lines.rows);
  for (const double one : lines.rows) result.row += W * (one - mean) * (one - mean) / result.row_dof;
  for (const double one : lines.columns) result.column += V * one * one / result.column_dof;
  if (const double kept = static_cast<double>(n - left_out), variance = squares / kept; squares > 0.0) {
    result.skewness = cubes / kept / std::pow(variance, 1.5);
    result.kurtosis = fourths / kept / (variance * variance);
  }
  result.row_means = std::move(lines.rows);
  result.column_means = std::move(lines.columns);
  return result;
}

void warn_of_shape(const std::string& name, const PlaneSquares& plane, std::vector<std::string>& warnings) {
  const double chance =
      5.0 * std::sqrt(6.0 / std::max(1.0, plane.pixel_dof));  // of the skewness; twice it the kurtosis
  if (!(plane.kurtosis > 0.0) ||
      (std::abs(plane.skewness) < std::max(1.0, chance) && plane.kurtosis > 3.0 - std::max(1.0, 2.0 * chance) &&
       plane.kurtosis < 3.0 + std::max(2.0, 2.0 * chance)))
    return;
  warnings.push_back(name + ": its pixels are far from normal (skewness " + mtf::significant(plane.skewness, 2) +
                     ", kurtosis " + mtf::significant(plane.kurtosis, 2) +
                     ", where 0 and 3 are normal), as when they fall into two groups: one rms describes them badly, "
                     "and its error is that of a normal pattern");
}

Pattern pattern_of(const PlaneSquares& plane, const std::vector<AveragedStack>& stacks) {
  std::vector<MeanSquareTerm> pixel{{1.0, plane.pixel, plane.pixel_dof}};
  const double V = plane.rows, H = plane.columns;
  std::vector<MeanSquareTerm> row{{1.0 / H, plane.row, plane.row_dof}, {-1.0 / H, plane.pixel, plane.pixel_dof}};
  std::vector<MeanSquareTerm> column{{1.0 / V, plane.column, plane.column_dof},
                                     {-1.0 / V, plane.pixel, plane.pixel_dof}};
  double rounding = 0.0, rounding_sd = 0.0, temporal = 0.0, temporal_row = 0.0, temporal_column = 0.0;
  for (const AveragedStack& stack : stacks) {
    const auto term = [&](std::size_t part, double factor) {
      return MeanSquareTerm{factor / stack.squares.frames, stack.squares.value[part], stack.squares.dof(part)};
    };
    pixel.push_back(term(kTvh, -1.0));
    row.push_back(term(kTv, -1.0 / H));
    row.push_back(term(kTvh, 1.0 / H));
    column.push_back(term(kTh, -1.0 / V));
    column.push_back(term(kTvh, 1.0 / V));
    rounding += stack.pattern;
    rounding_sd += stack.pattern_sd;  // of one number in all
    temporal += stack.squares.value[kTvh] / stack.squares.frames;
    temporal_row += stack.squares.value[kTv] / stack.squares.frames;
    temporal_column += stack.squares.value[kTh] / stack.squares.frames;
  }
  Pattern result{
      .pixel = variance_component(pixel), .row = variance_component(row), .column = variance_component(column)};
  for (double* const value : {&result.pixel.variance, &result.pixel.low95, &result.pixel.high95}) *value -= rounding;
  widen(result.pixel, rounding_sd);
  // Of a given pattern a mean square is chi-square about it: variance (2 a^2 + 4 a b)/dof with a temporal and b fixed.
  const auto sd_array = [](double a, double mean_square, double dof, double divisor) {
    return std::sqrt((2.0 * a * a + 4.0 * a * std::max(0.0, mean_square - a)) / dof) / divisor;
  };
  result.pixel_sd_array = sd_array(temporal, plane.pixel, plane.pixel_dof, 1.0);
  result.row_sd_array = sd_array(temporal_row, plane.row, plane.row_dof, H);
  result.column_sd_array = sd_array(temporal_column, plane.column, plane.column_dof, V);
  return result;
}

Trend remove_trend(mtf::ImageView<float> plane, int degree) {
  Trend trend;
  trend.degree = static_cast<int>(std::min<std::int64_t>(degree, std::min(plane.width, plane.height) / kPixelsADegree));
  if (trend.degree <= 0) return trend;
  const auto n = static_cast<std::size_t>(trend.degree);
  const auto along_x = orthonormal(plane.width, trend.degree), along_y = orthonormal(plane.height, trend.degree);
  std::vector<double> found((n + 1) * (n + 1), 0.0);  // [degree of y][of x]
  // Of pixels beyond the limit nothing is known: they take part as the trend has them, which passes settle.
  double far = INFINITY;
  for (int pass = 0; pass < kTrendPasses; ++pass) {
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

mtf::Image pattern_map(mtf::ImageView<const float> plane, const PlaneSquares& squares, const PatternRms& found) {
  const auto factor = [](double rms2, double mean_square) {
    return mean_square > 0.0 ? std::sqrt(std::min(1.0, rms2 / mean_square)) : 0.0;
  };
  // White pixels have means of rows and columns too.
  const double pixel2 = found.pixel * found.pixel, pixel = factor(pixel2, squares.pixel);
  const double row = factor(pixel2 + squares.columns * found.row * found.row, squares.row);
  const double column = factor(pixel2 + squares.rows * found.column * found.column, squares.column);
  const double mean = mean_of(squares.row_means);
  mtf::Image map(plane.width, plane.height);
  for (std::int64_t y = 0; y < plane.height; ++y)
    for (std::int64_t x = 0; x < plane.width; ++x)
      map.at(x, y) = static_cast<float>(pixel * squares.deviation(plane, x, y) +
                                        row * (squares.row_means[static_cast<std::size_t>(y)] - mean) +
                                        column * squares.column_means[static_cast<std::size_t>(x)]);
  double left = mtf::statistics(map.view()).mean * static_cast<double>(map.size());
  for (const Defect& defect : squares.defects) {
    left -= static_cast<double>(map.at(defect.x, defect.y));
    map.at(defect.x, defect.y) += static_cast<float>((1.0 - pixel) * defect.excess);
  }
  left /= static_cast<double>(map.size() - std::ssize(squares.defects));
  for (std::int64_t i = 0; i < map.size(); ++i) map.data()[i] -= static_cast<float>(left);
  return map;
}

}  // namespace calib
