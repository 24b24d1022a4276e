// SPDX-License-Identifier: Apache-2.0
#include "radiometry/light/path_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "mtf/engines/statistics.h"
#include "mtf/parallel.h"
#include "radiometry/light/pixel_rules.h"

namespace radiometry {
namespace {

constexpr double kError = 1e-7;
constexpr std::size_t kMostCells = 4096, kFewestCells = 16;
constexpr std::size_t kMostWork = 100'000'000;  ///< cells x wavelengths between two ranges

/// A mean transmission and its change over a whole segment.
struct Node {
  double tau = 0.0, slope = 0.0;
};

/// The weighted mean of transmissions that go from tau0 to tau1 while t goes from 0 to 1, each as PathTable has it.
class Mean {
 public:
  Mean(std::span<const double> weight, std::span<const double> tau0, std::span<const double> tau1) {
    for (std::size_t j = 0; j < weight.size(); ++j) {
      if (weight[j] == 0.0) continue;
      if (tau0[j] > 0.0 && tau1[j] > 0.0) {
        start_.push_back(weight[j] * tau0[j]);
        log_ratio_.push_back(std::log(tau1[j] / tau0[j]));
      } else {
        line0_ += weight[j] * tau0[j];
        line1_ += weight[j] * tau1[j];
      }
    }
  }
  Node at(double t) const {
    Node node{line0_ * (1.0 - t) + line1_ * t, line1_ - line0_};
    for (std::size_t j = 0; j < start_.size(); ++j) {
      const double tau = start_[j] * std::exp(t * log_ratio_[j]);
      node.tau += tau;
      node.slope += tau * log_ratio_[j];
    }
    return node;
  }

 private:
  std::vector<double> start_, log_ratio_;
  double line0_ = 0.0, line1_ = 0.0;
};

double sum(std::span<const double> weight, std::span<const double> value) {
  return std::inner_product(weight.begin(), weight.end(), value.begin(), 0.0);
}

void refuse_ranges(mtf::ImageView<const float> range_m, double longest_m, const std::string& source, int threads) {
  const auto most = static_cast<float>(longest_m);
  refuse_pixels(
      range_m,
      {"depth", "without a range from above 0 to " + mtf::format_double(longest_m) + " m, the end of " + source,
       "give every pixel its range in m, or a table that goes as far"},
      threads, [most](float r) { return !(r > 0.0F && r <= most); });
}

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

void require_ranges(mtf::ImageView<const float> range_m, const PathTable& table, int threads) {
  refuse_ranges(range_m, table.range_m().back(), table.source(), threads);
}

RangeTable::RangeTable(const SceneBand& scene, const PathTable& table, std::optional<double> source_k)
    : source_(table.source()), range_m_(table.range_m()) {
  const std::size_t size = table.wavelength_um().size();
  std::vector<double> weight = shape_weights(scene, table.wavelength_um(), source_k).weight;
  const std::vector<double> added = channel_weights(scene, table.wavelength_um()).weight;
  const BandResponse response(scene.band, scene.curves);
  const double whole = source_k ? response.radiance(scene.flux, *source_k) : response.integral();
  if (!(whole > 0.0) || !std::isfinite(whole))
    throw mtf::UsageError(source_ + ": a scene " +
                          (source_k ? "of " + mtf::format_double(*source_k) + " K " : std::string()) +
                          "gives nothing in the band " + describe(scene.band) +
                          " to weigh transmissions by; give another source_temperature, or none");
  for (double& w : weight) w /= whole;

  // The path is clear at range 0; beyond the wavelengths of the table no light passes.
  std::vector<double> tau0(size, 1.0), radiance0(size, 0.0);
  double from_m = 0.0;
  const std::size_t most = std::clamp(kMostWork / size, kFewestCells, kMostCells);
  for (std::size_t i = 0; i < range_m_.size(); ++i) {
    const std::vector<double>&tau1 = table.transmission()[i], &radiance1 = table.radiance()[i];
    const double length = range_m_[i] - from_m;
    const Mean mean(weight, tau0, tau1);
    std::size_t count = 2;
    std::vector<Node> nodes{mean.at(0.0), mean.at(0.5), mean.at(1.0)};
    for (bool fine = false; !fine && count < most; count *= 2) {
      std::vector<Node> twice{nodes[0]};
      fine = true;
      for (std::size_t k = 0; k < count; ++k) {
        const double h = 1.0 / static_cast<double>(count);
        const Node &a = nodes[k], &b = nodes[k + 1], middle = mean.at((static_cast<double>(k) + 0.5) * h);
        const double guess = 0.5 * (a.tau + b.tau) + 0.125 * h * (a.slope - b.slope);
        fine = fine && std::abs(guess - middle.tau) <= 8.0 * kError * middle.tau;
        twice.insert(twice.end(), {middle, b});
      }
      nodes = std::move(twice);
    }
    const double first_radiance = sum(added, radiance0);
    segments_.push_back({from_m, static_cast<double>(count) / length, first_radiance,
                         (sum(added, radiance1) - first_radiance) / length, cells_.size(), count});
    for (std::size_t k = 0; k < count; ++k) {
      const double h = 1.0 / static_cast<double>(count), a = nodes[k].slope * h, b = nodes[k + 1].slope * h;
      const double rise = nodes[k + 1].tau - nodes[k].tau;
      cells_.push_back({nodes[k].tau, a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise});
    }
    tau0 = tau1;
    radiance0 = radiance1;
    from_m = range_m_[i];
  }
}

const RangeTable::Segment& RangeTable::checked(double range_m) const {
  if (!(range_m >= 0.0 && range_m <= longest_m()))
    throw mtf::UsageError(source_ + ": a path of " + mtf::format_double(range_m) + " m; the table goes from 0 to " +
                          mtf::format_double(longest_m()) + " m");
  return segment(range_m);
}

const RangeTable::Segment& RangeTable::segment(double range_m) const {
  const auto end = std::lower_bound(range_m_.begin(), range_m_.end() - 1, range_m);
  return segments_[static_cast<std::size_t>(end - range_m_.begin())];
}

double RangeTable::transmission(const Segment& segment, double range_m) const {
  const double place = (range_m - segment.from_m) * segment.cells_per_m;
  const std::size_t k = std::min(static_cast<std::size_t>(place), segment.count - 1);
  const Cell& cell = cells_[segment.first + k];
  const double t = place - static_cast<double>(k);
  return cell.c0 + t * (cell.c1 + t * (cell.c2 + t * cell.c3));
}

double RangeTable::transmission(double range_m) const { return transmission(checked(range_m), range_m); }

double RangeTable::radiance(double range_m) const {
  const Segment& s = checked(range_m);
  return s.radiance + (range_m - s.from_m) * s.radiance_per_m;
}

void RangeTable::apply(mtf::ImageView<float> radiance, mtf::ImageView<const float> range_m, int threads) const {
  require_size_of(radiance, range_m, "depth");
  refuse_ranges(range_m, longest_m(), source_, threads);
  for_each_pixel(radiance, range_m, threads, [&](float light, float range) {
    const double r = std::min(static_cast<double>(range), longest_m());
    const Segment& s = segment(r);
    return static_cast<float>(transmission(s, r) * static_cast<double>(light) + s.radiance +
                              (r - s.from_m) * s.radiance_per_m);
  });
}

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
