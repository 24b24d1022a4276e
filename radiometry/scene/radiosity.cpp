// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "mtf/error.h"
#include "mtf/math/simd.h"
#include "radiometry/scene/exchange.h"

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

}  // namespace radiometry::scene
