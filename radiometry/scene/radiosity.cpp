// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "mtf/error.h"
#include "radiometry/scene/conjugate_gradients.h"
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

/// Of row i.
double times(const SparseRows& rows, std::size_t i, std::span<const double> x) {
  double sum = 0.0;
  for (std::uint64_t e = rows.first[i]; e < rows.first[i + 1]; ++e) sum += rows.value[e] * x[rows.column[e]];
  return sum;
}

}  // namespace

Radiosity radiosity(const Exchange& exchange, std::span<const double> emitted, std::span<const double> reflectance,
                    std::span<const double> from_outside, double tolerance) {
  const std::size_t n = exchange.patches();
  check_sizes(n, {emitted.size(), reflectance.size(), from_outside.size()}, "patches");
  check_reflectance(reflectance, "patch");

  std::vector<double> to_flux(n), z(n), right(n);  // rho H = to_flux z
  for (std::size_t i = 0; i < n; ++i) to_flux[i] = std::sqrt(reflectance[i] / exchange.area_m2[i]);
  const auto from_flux = [&](std::size_t i, double flux) {
    return std::sqrt(reflectance[i] * exchange.area_m2[i]) * flux;
  };
  for (std::size_t i = 0; i < n; ++i) right[i] = from_flux(i, from_outside[i] + times(exchange.factors, i, emitted));
  std::vector<double> given_off(n);
  const auto multiply = [&](const std::vector<double>& x) {
    for (std::size_t i = 0; i < n; ++i) given_off[i] = to_flux[i] * x[i];
    std::vector<double> image(n);
    for (std::size_t i = 0; i < n; ++i) image[i] = x[i] - from_flux(i, times(exchange.factors, i, given_off));
    return image;
  };
  const LinearSolution solved = conjugate_gradients(multiply, std::move(right), tolerance, kMostIterations);
  if (!(solved.residual <= tolerance))
    throw mtf::RuntimeError("radiosity: the relative residual is " + std::to_string(solved.residual) + " after " +
                            std::to_string(solved.iterations) +
                            " iterations: lower the reflectance of surfaces that are almost mirrors, or the demand.");

  Radiosity result{.irradiance_w_m2 = std::vector<double>(n),
                   .radiosity_w_m2 = std::vector<double>(n),
                   .iterations = solved.iterations};
  for (std::size_t i = 0; i < n; ++i) result.radiosity_w_m2[i] = emitted[i] + to_flux[i] * solved.x[i];
  for (std::size_t i = 0; i < n; ++i)
    result.irradiance_w_m2[i] = from_outside[i] + times(exchange.factors, i, result.radiosity_w_m2);
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
  for (std::size_t i = 0; i < receivers; ++i)
    irradiance[i] = fluxes.environment[i] + fluxes.direct[i] + times(exchange.rows, i, patch.radiosity_w_m2);
  std::vector<double> shift = patch_means([&](std::size_t i) { return irradiance[i]; });
  for (std::size_t p = 0; p < patches; ++p) shift[p] = patch.irradiance_w_m2[p] - shift[p];
  for (std::size_t i = 0; i < receivers; ++i) irradiance[i] += shift[exchange.patch_of[i]];
  return irradiance;
}

}  // namespace radiometry::scene
