// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/exchange.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "mtf/error.h"
#include "mtf/math/simd.h"

namespace radiometry::scene {
namespace {

constexpr int kMostIterations = 2000;

void check_sizes(std::size_t count, std::initializer_list<std::size_t> sizes, const std::string& what) {
  for (const std::size_t size : sizes)
    if (size != count)
      throw mtf::UsageError("radiosity: there are " + std::to_string(count) + " " + what + " and " +
                            std::to_string(size) + " values for them.");
}

void check_reflectance(std::span<const double> reflectance, const std::string& what) {
  for (std::size_t i = 0; i < reflectance.size(); ++i)
    if (!(reflectance[i] >= 0.0 && reflectance[i] < 1.0))
      throw mtf::UsageError("radiosity: the reflectance of " + what + " " + std::to_string(i) + " is " +
                            std::to_string(reflectance[i]) + ", it must be at least 0 and below 1.");
}

/// One row of a product, for all columns of `x`, which stand side by side.
struct MultiplyRow {
  template <int Bytes>
  static MTFKIT_INLINE void run(std::size_t entries, const std::uint32_t* row, const double* value, std::size_t columns,
                                const double* x, double* __restrict y) {
    constexpr std::size_t kBlock = 16;
    std::size_t c = 0;
    for (; c + kBlock <= columns; c += kBlock) {
      double sum[kBlock] = {};
      for (std::size_t e = 0; e < entries; ++e) {
        const double* from = x + row[e] * columns + c;
        for (std::size_t l = 0; l < kBlock; ++l) sum[l] += value[e] * from[l];
      }
      for (std::size_t l = 0; l < kBlock; ++l) y[c + l] = sum[l];
    }
    for (; c < columns; ++c) {
      double sum = 0.0;
      for (std::size_t e = 0; e < entries; ++e) sum += value[e] * x[row[e] * columns + c];
      y[c] = sum;
    }
  }
};

/// Conjugate gradients for all columns side by side, each with its own steps: as in exchange.cpp, with A x =
/// x - right F (left x).
class Columns {
 public:
  Columns(const Exchange& exchange, std::span<const double> reflectance, std::size_t columns)
      : exchange_(exchange), columns_(columns), n_(exchange.patches()), scratch_(n_ * columns), image_(n_ * columns) {
    for (std::size_t i = 0; i < n_; ++i) {
      left_.push_back(std::sqrt(reflectance[i] / exchange.area_m2[i]));
      right_.push_back(std::sqrt(reflectance[i] * exchange.area_m2[i]));
    }
  }

  const std::vector<double>& to_flux() const { return left_; }
  const std::vector<double>& from_flux() const { return right_; }

  /// Right-hand sides in, the solution out; the most iterations of any column, and its relative residual.
  std::pair<int, double> solve(std::vector<double>& b, double tolerance) {
    std::vector<double> residual = b, direction = std::move(b);
    b.assign(residual.size(), 0.0);
    const std::vector<double> start = products(residual, residual);
    std::vector<double> squares = start, step(columns_), ratio(columns_);
    const auto open = [&](std::size_t c) { return squares[c] > tolerance * tolerance * start[c]; };
    int iterations = 0;
    for (; iterations < kMostIterations; ++iterations) {
      bool any = false;
      for (std::size_t c = 0; c < columns_; ++c) any = any || open(c);
      if (!any) break;
      multiply(direction);
      const std::vector<double> curvature = products(direction, image_);
      for (std::size_t c = 0; c < columns_; ++c)
        step[c] = open(c) && curvature[c] > 0.0 ? squares[c] / curvature[c] : 0.0;
      for (std::size_t i = 0; i < n_; ++i)
        for (std::size_t c = 0; c < columns_; ++c) {
          const std::size_t at = i * columns_ + c;
          b[at] += step[c] * direction[at];
          residual[at] -= step[c] * image_[at];
        }
      const std::vector<double> next = products(residual, residual);
      for (std::size_t c = 0; c < columns_; ++c) {
        ratio[c] = squares[c] > 0.0 ? next[c] / squares[c] : 0.0;
        squares[c] = next[c];
      }
      for (std::size_t i = 0; i < n_; ++i)
        for (std::size_t c = 0; c < columns_; ++c)
          direction[i * columns_ + c] = residual[i * columns_ + c] + ratio[c] * direction[i * columns_ + c];
    }
    double worst = 0.0;
    for (std::size_t c = 0; c < columns_; ++c)
      if (start[c] > 0.0) worst = std::max(worst, std::sqrt(squares[c] / start[c]));
    return {iterations, worst};
  }

 private:
  std::vector<double> products(const std::vector<double>& p, const std::vector<double>& q) const {
    std::vector<double> sums(columns_, 0.0);
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t c = 0; c < columns_; ++c) sums[c] += p[i * columns_ + c] * q[i * columns_ + c];
    return sums;
  }
  void multiply(const std::vector<double>& x) {
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t c = 0; c < columns_; ++c) scratch_[i * columns_ + c] = left_[i] * x[i * columns_ + c];
    times(exchange_.factors, columns_, scratch_, image_);
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t c = 0; c < columns_; ++c) {
        double& image = image_[i * columns_ + c];
        image = x[i * columns_ + c] - right_[i] * image;
      }
  }

  const Exchange& exchange_;
  std::size_t columns_, n_;
  std::vector<double> left_, right_, scratch_, image_;
};

// Conjugate gradients (Hestenes and Stiefel, J. Res. NBS 49, 1952) for A x = b with A symmetric and positive definite,
// or semidefinite with b in its range.

struct LinearSolution {
  std::vector<double> x;
  int iterations = 0;
  double residual = 0.0;  ///< relative, in the Euclidean norm
};

/// `multiply(p)` returns A p. Ends at the relative residual `tolerance`, after `most` iterations, or where A is not
/// positive.
template <class Multiply>
LinearSolution conjugate_gradients(const Multiply& multiply, std::vector<double> b, double tolerance, int most) {
  const auto product = [](const std::vector<double>& p, const std::vector<double>& q) {
    return std::inner_product(p.begin(), p.end(), q.begin(), 0.0);
  };
  LinearSolution solution{.x = std::vector<double>(b.size(), 0.0)};
  const double start = product(b, b);
  if (start == 0.0) return solution;
  std::vector<double> residual = std::move(b), direction = residual;
  double squares = start;
  while (squares > tolerance * tolerance * start && solution.iterations < most) {
    const std::vector<double> image = multiply(direction);
    const double curvature = product(direction, image);
    if (!(curvature > 0.0)) break;  // b is not in the range of A
    const double step = squares / curvature;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      solution.x[i] += step * direction[i];
      residual[i] -= step * image[i];
    }
    const double next = product(residual, residual), ratio = next / squares;
    for (std::size_t i = 0; i < residual.size(); ++i) direction[i] = residual[i] + ratio * direction[i];
    squares = next;
    ++solution.iterations;
  }
  solution.residual = std::sqrt(squares / start);
  return solution;
}

/// One value of a symmetric matrix, row <= column, and what was sampled: S_ij and S_ji, the same on the diagonal. The
/// variance of the value is itself times `ray_area`.
struct Pair {
  std::uint32_t row, column;
  double value, sampled, sampled_back, ray_area;
};

/// Exchange areas between patches, m^2.
struct ExchangeAreas {
  std::vector<Pair> pairs{};    // rows, then columns, rising
  std::vector<double> leaving;  // A_i l_i
  std::vector<double> area;
  std::vector<double> ray_area;  // a_i
};

ExchangeAreas sampled_areas(const Views& views, std::span<const double> receiver_area,
                            std::span<const std::uint32_t> patch_of, std::size_t patches) {
  const std::vector<double> zero(patches, 0.0);
  ExchangeAreas areas{.leaving = zero, .area = zero, .ray_area = zero};
  std::vector<Pair> parts;
  parts.reserve(views.patches.value.size());
  for (std::size_t i = 0; i < patch_of.size(); ++i) {
    const std::uint32_t p = patch_of[i];
    areas.area[p] += receiver_area[i];
    areas.ray_area[p] += receiver_area[i] * receiver_area[i] / views.rays[i];
    areas.leaving[p] += receiver_area[i] * (views.sky_share(i) + views.ground[i]);
    for (std::uint64_t e = views.patches.first[i]; e < views.patches.first[i + 1]; ++e) {
      const std::uint32_t q = views.patches.column[e];
      const double part = receiver_area[i] * views.patches.value[e];
      parts.push_back({std::min(p, q), std::max(p, q), 0.0, p <= q ? part : 0.0, p >= q ? part : 0.0, 0.0});
    }
  }
  for (std::size_t p = 0; p < patches; ++p) areas.ray_area[p] /= areas.area[p];
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Pair& a, const Pair& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; });
  for (const Pair& part : parts) {
    if (areas.pairs.empty() || areas.pairs.back().row != part.row || areas.pairs.back().column != part.column) {
      areas.pairs.push_back(part);
    } else {
      areas.pairs.back().sampled += part.sampled;
      areas.pairs.back().sampled_back += part.sampled_back;
    }
  }
  for (Pair& pair : areas.pairs) {
    const double a = areas.ray_area[pair.row], b = areas.ray_area[pair.column];
    pair.value = (b * pair.sampled + a * pair.sampled_back) / (a + b);
    pair.ray_area = pair.row == pair.column ? a : a * b / (a + b);
  }
  return areas;
}

/// (M x) added to `image`, for the symmetric matrix with the values `value(pair)`.
template <class Value>
void add_product(std::span<const Pair> pairs, const Value& value, const std::vector<double>& x,
                 std::vector<double>& image) {
  for (const Pair& pair : pairs) {
    image[pair.row] += value(pair) * x[pair.column];
    if (pair.row != pair.column) image[pair.column] += value(pair) * x[pair.row];
  }
}

double value_of(const Pair& pair) { return pair.value; }
double variance_of(const Pair& pair) { return pair.value * pair.ray_area; }

std::vector<double> row_sums(const ExchangeAreas& areas) {
  std::vector<double> sums = areas.leaving;
  add_product(areas.pairs, value_of, std::vector<double>(sums.size(), 1.0), sums);
  return sums;
}

/// Closes the rows; returns the largest share that a patch's view of itself had to take.
double close(ExchangeAreas& areas) {
  constexpr double kTolerance = 1e-15;
  constexpr int kMostSteps = 1000;
  const std::size_t n = areas.area.size();
  const std::vector<double> sums = row_sums(areas);
  std::vector<double> variance(n);  // of the row sums
  for (std::size_t i = 0; i < n; ++i) variance[i] = areas.leaving[i] * areas.ray_area[i];
  add_product(areas.pairs, variance_of, std::vector<double>(n, 1.0), variance);
  // In y = sqrt(variance) x, so that patches of a square millimetre and of a hectare are closed alike.
  std::vector<double> root(n), lack(n);
  for (std::size_t i = 0; i < n; ++i) {
    root[i] = std::sqrt(variance[i]);
    lack[i] = (areas.area[i] - sums[i]) / root[i];
  }
  const auto multiply = [&](const std::vector<double>& y) {
    std::vector<double> x(n), image(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) x[i] = y[i] / root[i];
    add_product(areas.pairs, variance_of, x, image);
    for (std::size_t i = 0; i < n; ++i) image[i] = y[i] + image[i] / root[i];
    return image;
  };
  std::vector<double> x = conjugate_gradients(multiply, std::move(lack), kTolerance, kMostSteps).x;
  for (std::size_t i = 0; i < n; ++i) x[i] /= root[i];
  for (Pair& pair : areas.pairs) pair.value *= std::max(0.0, 1.0 + pair.ray_area * (x[pair.row] + x[pair.column]));
  for (std::size_t i = 0; i < n; ++i) areas.leaving[i] *= std::max(0.0, 1.0 + areas.ray_area[i] * x[i]);

  // Only rounding is left to do, unless a value fell to 0.
  std::vector<double> scale = row_sums(areas);
  for (std::size_t i = 0; i < n; ++i) scale[i] = std::min(1.0, areas.area[i] / scale[i]);
  for (Pair& pair : areas.pairs) pair.value *= std::min(scale[pair.row], scale[pair.column]);
  for (std::size_t i = 0; i < n; ++i) areas.leaving[i] *= scale[i];
  const std::vector<double> closed = row_sums(areas);
  std::vector<double> own(n);
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    own[i] = std::max(0.0, areas.area[i] - closed[i]);
    largest = std::max(largest, own[i] / areas.area[i]);
  }
  for (Pair& pair : areas.pairs)
    if (pair.row == pair.column) pair.value += std::exchange(own[pair.row], 0.0);
  for (std::uint32_t i = 0; i < n; ++i)
    if (own[i] > 0.0) areas.pairs.push_back({i, i, own[i], 0.0, 0.0, 0.0});
  return largest;
}

SparseRows factors_of(const ExchangeAreas& areas) {
  const std::size_t n = areas.area.size();
  SparseRows factors{.first = std::vector<std::uint64_t>(n + 1, 0)};
  for (const Pair& pair : areas.pairs) {
    ++factors.first[pair.row + 1];
    if (pair.row != pair.column) ++factors.first[pair.column + 1];
  }
  std::partial_sum(factors.first.begin(), factors.first.end(), factors.first.begin());
  factors.column.resize(factors.first.back());
  factors.value.resize(factors.first.back());
  std::vector<std::uint64_t> next(factors.first.begin(), factors.first.end() - 1);
  const auto put = [&](std::uint32_t row, std::uint32_t column, double value) {
    factors.column[next[row]] = column;
    factors.value[next[row]++] = value / areas.area[row];
  };
  // Pairs below the diagonal come in the order of their columns first, then the others: columns rise in every row.
  for (const Pair& pair : areas.pairs)
    if (pair.row != pair.column) put(pair.column, pair.row, pair.value);
  for (const Pair& pair : areas.pairs) put(pair.row, pair.column, pair.value);
  return factors;
}

double rms_change(const ExchangeAreas& areas) {
  double squares = 0.0, total = 0.0;
  for (const Pair& pair : areas.pairs) {
    const double change = pair.value - pair.sampled, change_back = pair.value - pair.sampled_back;
    squares += change * change / areas.area[pair.row];
    if (pair.row != pair.column) squares += change_back * change_back / areas.area[pair.column];
  }
  for (const double area : areas.area) total += area;
  return std::sqrt(squares / total);
}

}  // namespace

void times(const SparseRows& rows, std::size_t columns, std::span<const double> x, std::span<double> y) {
  for (std::size_t i = 0; i + 1 < rows.first.size(); ++i) {
    const std::uint64_t first = rows.first[i];
    mtf::simd::run<MultiplyRow>(static_cast<std::size_t>(rows.first[i + 1] - first), rows.column.data() + first,
                                rows.value.data() + first, columns, x.data(), y.data() + i * columns);
  }
}

Radiosity radiosity(const Exchange& exchange, std::span<const double> emitted, std::span<const double> reflectance,
                    std::span<const double> from_outside, double tolerance, std::size_t columns) {
  const std::size_t n = exchange.patches();
  check_sizes(n, {reflectance.size()}, "patches");
  check_sizes(n * columns, {emitted.size(), from_outside.size()}, "patches");
  check_reflectance(reflectance, "patch");

  Radiosity result{.irradiance_w_m2 = std::vector<double>(n * columns), .iterations = 0};
  Columns system(exchange, reflectance, columns);
  std::vector<double> z(n * columns);  // rho H = to_flux z
  times(exchange.factors, columns, emitted, z);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < columns; ++c)
      z[i * columns + c] = system.from_flux()[i] * (from_outside[i * columns + c] + z[i * columns + c]);
  double residual = 0.0;
  std::tie(result.iterations, residual) = system.solve(z, tolerance);
  if (!(residual <= tolerance))
    throw mtf::RuntimeError("radiosity: the relative residual is " + std::to_string(residual) + " after " +
                            std::to_string(result.iterations) +
                            " iterations: lower the reflectance of surfaces that are almost mirrors, or the demand.");
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < columns; ++c)
      z[i * columns + c] = emitted[i * columns + c] + system.to_flux()[i] * z[i * columns + c];
  times(exchange.factors, columns, z, result.irradiance_w_m2);
  for (std::size_t e = 0; e < n * columns; ++e) result.irradiance_w_m2[e] += from_outside[e];
  result.radiosity_w_m2 = std::move(z);
  return result;
}

std::vector<double> irradiance_w_m2(const Exchange& exchange, const ReceiverFluxes& fluxes, double tolerance) {
  const std::size_t patches = exchange.patches(), receivers = exchange.receivers();
  check_sizes(receivers,
              {fluxes.emitted.size(), fluxes.reflectance.size(), fluxes.environment.size(), fluxes.direct.size()},
              "receivers");
  check_reflectance(fluxes.reflectance, "receiver");
  const auto patch_means = [&](const auto& value) {
    std::vector<double> means(patches, 0.0);
    for (std::size_t i = 0; i < receivers; ++i)
      means[exchange.patch_of[i]] += exchange.receiver_area_m2[i] / exchange.area_m2[exchange.patch_of[i]] * value(i);
    return means;
  };
  std::vector<double> outside = patch_means([&](std::size_t i) { return fluxes.environment[i]; });
  const std::vector<double> direct = patch_means([&](std::size_t i) { return fluxes.direct[i]; });
  for (std::size_t p = 0; p < patches; ++p) outside[p] = exchange.leaving_scale[p] * outside[p] + direct[p];
  const Radiosity patch =
      radiosity(exchange, patch_means([&](std::size_t i) { return fluxes.emitted[i]; }),
                patch_means([&](std::size_t i) { return fluxes.reflectance[i]; }), outside, tolerance);

  std::vector<double> irradiance(receivers);
  times(exchange.rows, 1, patch.radiosity_w_m2, irradiance);
  for (std::size_t i = 0; i < receivers; ++i) irradiance[i] += fluxes.environment[i] + fluxes.direct[i];
  std::vector<double> shift = patch_means([&](std::size_t i) { return irradiance[i]; });
  for (std::size_t p = 0; p < patches; ++p) shift[p] = patch.irradiance_w_m2[p] - shift[p];
  for (std::size_t i = 0; i < receivers; ++i) irradiance[i] += shift[exchange.patch_of[i]];
  return irradiance;
}

Exchange exchange_of(const Views& views, std::span<const double> receiver_area, std::span<const std::uint32_t> patch_of,
                     std::size_t patches) {
  if (views.patches.rows() != patch_of.size() || views.rays.size() != patch_of.size() ||
      receiver_area.size() != patch_of.size())
    throw mtf::UsageError("exchange_of: there are views of " + std::to_string(views.patches.rows()) +
                          " receivers with patches, areas of " + std::to_string(receiver_area.size()) +
                          " and patches of " + std::to_string(patch_of.size()));
  for (const std::uint32_t p : patch_of)
    if (p >= patches)
      throw mtf::UsageError("exchange_of: a receiver belongs to patch " + std::to_string(p) + " of " +
                            std::to_string(patches));
  for (const std::uint32_t q : views.patches.column)
    if (q >= patches)
      throw mtf::UsageError("exchange_of: a view names patch " + std::to_string(q) + " of " + std::to_string(patches));
  ExchangeAreas areas = sampled_areas(views, receiver_area, patch_of, patches);
  for (std::size_t p = 0; p < patches; ++p)
    if (!(areas.area[p] > 0.0)) throw mtf::UsageError("exchange_of: patch " + std::to_string(p) + " has no receiver");

  const std::vector<double> sampled_leaving = areas.leaving;
  Exchange exchange;
  exchange.own_view = close(areas);
  exchange.change = rms_change(areas);
  std::sort(areas.pairs.begin(), areas.pairs.end(),
            [](const Pair& a, const Pair& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; });
  exchange.factors = factors_of(areas);
  for (std::size_t p = 0; p < patches; ++p) {
    exchange.leaving.push_back(areas.leaving[p] / areas.area[p]);
    exchange.leaving_scale.push_back(sampled_leaving[p] > 0.0 ? areas.leaving[p] / sampled_leaving[p] : 1.0);
  }
  exchange.area_m2 = std::move(areas.area);
  exchange.receiver_area_m2.assign(receiver_area.begin(), receiver_area.end());
  exchange.patch_of.assign(patch_of.begin(), patch_of.end());
  exchange.rows = views.patches;
  return exchange;
}

}  // namespace radiometry::scene
