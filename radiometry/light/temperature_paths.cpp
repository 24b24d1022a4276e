// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/temperature_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mtf/engines/statistics.h"
#include "mtf/parallel.h"
#include "radiometry/light/pixel_rules.h"

namespace radiometry {
namespace {

constexpr double kTemperatureError = 1e-7, kLeastShare = 1e-12;
constexpr int kFewest = 2, kMost = 16;  // intervals of the Chebyshev points; each doubling keeps the points before

SceneBand with_curve(SceneBand scene, const Spectrum& curve) {
  scene.curves.push_back(curve);
  return scene;
}

/// The least temperature from `coldest` on that emits more than a share of the hottest.
double least_seen_k(const SceneBand& scene, double coldest_k, double hottest_k) {
  const BandResponse response(scene.band, scene.curves);
  const double least = kLeastShare * response.radiance(scene.flux, hottest_k);
  if (response.radiance(scene.flux, coldest_k) >= least) return coldest_k;
  double lo = coldest_k, hi = hottest_k;
  while (hi - lo > 1e-3 * hi) {
    const double middle = 0.5 * (lo + hi);
    (response.radiance(scene.flux, middle) < least ? lo : hi) = middle;
  }
  return hi;
}

/// x_j = cos(pi j / n) between the inverse temperatures, from the coldest down to that of the hottest.
double chebyshev_point(double hottest_inverse, double coldest_inverse, int j, int n) {
  const double x = std::cos(std::numbers::pi * j / n);
  return 0.5 * (hottest_inverse + coldest_inverse) + 0.5 * (coldest_inverse - hottest_inverse) * x;
}

}  // namespace

TemperatureRangeTable::TemperatureRangeTable(const SceneBand& scene, const PathTable& table, double coldest_k,
                                             double hottest_k) {
  if (!(coldest_k >= 0.0 && coldest_k <= hottest_k && std::isfinite(hottest_k)))
    throw mtf::UsageError("temperatures from " + mtf::format_double(coldest_k) + " to " +
                          mtf::format_double(hottest_k) + " K; they are 0 or above, in kelvin");
  const double hot = 1.0 / hottest_k, cold = 1.0 / least_seen_k(scene, coldest_k, hottest_k);
  const auto add = [&](double inverse_k) {
    inverse_k_.push_back(inverse_k);
    tables_.emplace_back(scene, table, 1.0 / inverse_k);
  };
  if (!(cold > hot * (1.0 + 1e-9))) {
    add(hot);
    weight_ = {1.0};
    return;
  }
  const auto set_weights = [&] {
    const std::size_t last = inverse_k_.size() - 1;
    weight_.assign(last + 1, 1.0);
    for (std::size_t j = 1; j <= last; j += 2) weight_[j] = -1.0;
    weight_.front() *= 0.5;
    weight_.back() *= 0.5;
  };
  for (int j = 0; j <= kFewest; ++j) add(chebyshev_point(hot, cold, j, kFewest));
  set_weights();
  const BandResponse response(scene.band, scene.curves);
  const double hottest = response.radiance(scene.flux, hottest_k);
  for (int n = 2 * kFewest; n <= kMost; n *= 2) {
    // The points between those before, compared with what those say; then both in their order.
    std::vector<double> inverse_k;
    std::vector<RangeTable> tables;
    error_ = 0.0;
    for (int j = 1; j < n; j += 2) {
      const double inverse = chebyshev_point(hot, cold, j, n);
      const RangeTable& fresh = tables.emplace_back(scene, table, 1.0 / inverse);
      const double share = response.radiance(scene.flux, 1.0 / inverse) / hottest;
      for (const double range_m : table.range_m())
        error_ = std::max(error_, share * std::abs(transmission(1.0 / inverse, range_m) - fresh.transmission(range_m)));
      inverse_k.push_back(inverse);
    }
    for (std::size_t j = 0; j < tables.size(); ++j) {
      const auto place = static_cast<std::ptrdiff_t>(2 * j + 1);
      inverse_k_.insert(inverse_k_.begin() + place, inverse_k[j]);
      tables_.insert(tables_.begin() + place, std::move(tables[j]));
    }
    set_weights();
    if (error_ <= kTemperatureError) return;
  }
}

double TemperatureRangeTable::transmission(double temperature_k, double range_m) const {
  const double inverse = std::clamp(1.0 / temperature_k, inverse_k_.back(), inverse_k_.front());
  double sum = 0.0, of_weights = 0.0;
  for (std::size_t j = 0; j < tables_.size(); ++j) {
    const double distance = inverse - inverse_k_[j];
    const double tau = tables_[j].transmission(range_m);
    if (distance == 0.0) return tau;
    sum += weight_[j] / distance * tau;
    of_weights += weight_[j] / distance;
  }
  return sum / of_weights;
}

double radiance_at_ranges(mtf::ImageView<float> temperature_k, mtf::ImageView<const float> range_m,
                          const SceneBand& scene, const SurfaceFinish& finish, const PathTable& table,
                          const PlaneOptions& options) {
  require_size_of(temperature_k, range_m, "depth");
  require_ranges(range_m, table, options.threads);
  mtf::Image emitted = copy_of(temperature_k);
  radiance_of_temperature(emitted.view(), scene, {finish.emissivity, finish.plane, 0.0}, options);

  const bool by_pixel = finish.plane.data != nullptr;
  const mtf::Statistics warm = mtf::statistics(temperature_k);
  const double hottest_k = std::max(warm.max, 1.0);
  // Surfaces that emit nothing, mirrors or cold ones, have no spectrum to be taken from.
  const SceneBand emitting = by_pixel ? scene : with_curve(scene, finish.emissivity);
  std::optional<TemperatureRangeTable> tau;
  if (kLeastShare * BandResponse(emitting.band, emitting.curves).radiance(emitting.flux, hottest_k) >=
      std::numeric_limits<double>::min())
    tau.emplace(emitting, table, std::clamp(warm.min, 0.0, hottest_k), hottest_k);
  const RangeTable added(scene, table, std::nullopt);
  // What all surfaces reflect: of an emissivity by pixel, the part that one of emissivity 0 would.
  const SceneBand mirror = by_pixel ? scene : with_curve(scene, complement(finish.emissivity));
  const double reflected = finish.surroundings_k > 0.0
                               ? BandResponse(mirror.band, mirror.curves).radiance(mirror.flux, finish.surroundings_k)
                               : 0.0;
  std::optional<RangeTable> tau_reflected;
  if (reflected > 0.0) tau_reflected.emplace(mirror, table, finish.surroundings_k);

  mtf::parallel_for_each(temperature_k.height, kRowsAtOnce, options.threads, [&](std::int64_t y) {
    float* row = temperature_k.row(y);
    const float *light = emitted.view().row(y), *range = range_m.row(y);
    for (std::int64_t x = 0; x < temperature_k.width; ++x) {
      const double r = std::min(static_cast<double>(range[x]), added.longest_m());
      double sum = added.radiance(r);
      if (tau) sum += tau->transmission(static_cast<double>(row[x]), r) * static_cast<double>(light[x]);
      if (tau_reflected) {
        const double share = by_pixel ? 1.0 - static_cast<double>(finish.plane.at(x, y)) : 1.0;
        sum += share * reflected * tau_reflected->transmission(r);
      }
      row[x] = static_cast<float>(sum);
    }
  });
  return tau ? tau->error() : 0.0;
}

}  // namespace radiometry
