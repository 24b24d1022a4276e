// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/unit_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mtf/parallel.h"
#include "radiometry/light/constants.h"
#include "radiometry/thermal/facet_units.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;

constexpr std::size_t kEvery = 6;  // nodes: an hour, where they are 10 minutes apart

/// Every n-th facet of those that are asked for.
std::vector<std::uint32_t> picked(const HeatScene& scene, std::size_t count) {
  std::vector<std::uint32_t> all, some;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f)
    if (scene.is_seen(f)) all.push_back(f);
  const std::size_t step = std::max<std::size_t>(1, all.size() / count);
  for (std::size_t i = step / 2; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

double from_patches(const geometry::SparseRows& rows, std::size_t row, const std::vector<double>& radiosity) {
  double sum = 0.0;
  for (std::uint64_t i = rows.first[row]; i < rows.first[row + 1]; ++i)
    sum += rows.value[i] * radiosity[rows.column[i]];
  return sum;
}

/// A receiver of a sample: which one, its emissivity times sigma, and its weight in the mean.
struct Sampled {
  std::size_t receiver;
  double emission, weight;
};

/// The samples of patches that are not solved as a whole.
struct PatchSample {
  std::uint32_t patch = 0;
  double missing = 0.0;  ///< 1 - n / N
  std::vector<Sampled> sampled;
};

std::vector<PatchSample> samples_of(const Units& units, const std::vector<bool>& solved) {
  const scene::Exchange& exchange = units.exchange;
  std::vector<PatchSample> all(exchange.patches());
  std::vector<std::size_t> count(exchange.patches(), 0);
  for (std::size_t i = 0; i < units.unit.size(); ++i) {
    const Unit& unit = units.unit[i];
    const auto add = [&](std::size_t receiver, const UnitSide& side) {
      const std::uint32_t p = exchange.patch_of[receiver];
      ++count[p];
      if (solved[i])
        all[p].sampled.push_back(
            {receiver, side.emissivity * kStefanBoltzmann_w_m2_k4, exchange.receiver_area_m2[receiver]});
    };
    if (unit.given) continue;
    add(unit.receiver, unit.front);
    if (unit.has_own_back()) add(unit.back_receiver, *unit.back);
  }
  std::vector<PatchSample> some;
  for (std::uint32_t p = 0; p < all.size(); ++p) {
    PatchSample& one = all[p];
    if (one.sampled.size() == count[p]) continue;
    one.patch = p;
    one.missing = 1.0 - static_cast<double>(one.sampled.size()) / static_cast<double>(count[p]);
    double area = 0.0;
    for (const Sampled& sampled : one.sampled) area += sampled.weight;
    for (Sampled& sampled : one.sampled) sampled.weight /= area;
    some.push_back(std::move(one));
  }
  return some;
}

double variance_of(const PatchSample& patch, const HeatBatches& batches, std::size_t node) {
  const auto emitted = [&](const Sampled& one) {
    return one.emission * std::pow(batches.receiver_k(node, one.receiver), 4);
  };
  double mean = 0.0, squares = 0.0;
  for (const Sampled& one : patch.sampled) mean += one.weight * emitted(one);
  for (const Sampled& one : patch.sampled) squares += std::pow(one.weight * (emitted(one) - mean), 2);
  const auto n = static_cast<double>(patch.sampled.size());
  return n / std::max(n - 1.0, 1.0) * patch.missing * squares;
}

}  // namespace

ViewSpread view_spread(const HeatScene& scene, const Units& units, const GroundLight& ground,
                       const HeatBatches& batches, const Window& window, const HeatOptions& options,
                       double loss_w_m2_k) {
  const Surroundings& s = scene.surroundings;
  std::vector<std::uint32_t> facets;
  for (const std::uint32_t f : picked(scene, options.measured(scene.facets().size())))
    if (!units.unit[units.unit_of[f]].given) facets.push_back(f);
  if (facets.empty()) return {};
  std::vector<geometry::Side> sides;
  for (const std::uint32_t f : facets) sides.push_back({f, false});
  const geometry::Receivers receivers = geometry::single_sides(std::move(sides));
  std::vector<geometry::Views> own;
  for (const geometry::ViewOptions& set :
       geometry::other_sets({.rays = options.rays_of(scene.facets().size()), .threads = options.threads}))
    own.push_back(views(scene.rays, receivers, units.patch_of_side, units.exchange.patches(), set));
  std::vector<double> largest(facets.size(), 0.0), variance(facets.size(), 0.0);
  for (std::size_t node = window.first; node <= window.last; node += kEvery) {
    const std::vector<double> radiosity = batches.patch_radiosity(node);
    const double sky = s.sky_longwave_w_m2[node], below = ground.longwave_w_m2[node];
    for (std::size_t i = 0; i < facets.size(); ++i) {
      const Unit& unit = units.unit[units.unit_of[facets[i]]];
      geometry::OtherSets of_facet;
      for (const geometry::Views& seen : own)
        of_facet.add(seen.sky_share(i) * sky + seen.ground[i] * below + from_patches(seen.patches, i, radiosity));
      const double of_unit = unit.front.sky * sky + unit.front.ground * below +
                             from_patches(units.views.patches, unit.receiver, radiosity);
      const double kelvin = unit.front.emissivity / loss_w_m2_k;
      largest[i] = std::max(largest[i], kelvin * std::abs(of_facet.mean - of_unit));
      variance[i] = std::max(variance[i], kelvin * kelvin * of_facet.variance());
    }
  }
  ViewSpread spread;
  const double all = std::accumulate(variance.begin(), variance.end(), 0.0);
  spread.largest_k = std::hypot(*std::max_element(largest.begin(), largest.end()),
                                std::sqrt(all) / static_cast<double>(largest.size()));
  const std::size_t compared = largest.size();
  spread.error_k = geometry::error_of(std::move(largest), all, compared);
  return spread;
}

LeftOut left_out(const HeatScene& scene, const Units& units, const HeatBatches& batches, const Window& window,
                 double loss_w_m2_k, int threads) {
  LeftOut out;
  out.facets = static_cast<std::size_t>(std::count(scene.seen.begin(), scene.seen.end(), false));
  const std::vector<bool> solved = solved_units(units, scene);
  for (std::size_t i = 0; i < solved.size(); ++i) out.units += !solved[i] && !units.unit[i].given;
  const std::vector<PatchSample> samples = samples_of(units, solved);
  const scene::SparseRows& rows = units.exchange.rows;
  std::vector<double> worst(units.unit.size(), 0.0), variance(units.exchange.patches(), 0.0);
  for (std::size_t node = window.first; node <= window.last; node += kEvery) {
    for (const PatchSample& patch : samples) variance[patch.patch] = variance_of(patch, batches, node);
    mtf::parallel_for(static_cast<std::int64_t>(units.unit.size()), 1024, threads,
                      [&](std::int64_t begin, std::int64_t end) {
                        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                          const Unit& unit = units.unit[i];
                          if (unit.given || !scene.is_seen(unit.leader)) continue;
                          const auto add = [&](std::size_t r, const UnitSide& side) {
                            double sum = 0.0;
                            for (std::uint64_t e = rows.first[r]; e < rows.first[r + 1]; ++e)
                              sum += rows.value[e] * rows.value[e] * variance[rows.column[e]];
                            worst[i] = std::max(worst[i], side.emissivity * std::sqrt(sum));
                          };
                          add(unit.receiver, unit.front);
                          if (unit.back) add(unit.back_receiver, *unit.back);
                        }
                      });
  }
  std::vector<double> error_k;
  for (std::size_t i = 0; i < worst.size(); ++i)
    if (!units.unit[i].given && scene.is_seen(units.unit[i].leader)) error_k.push_back(worst[i] / loss_w_m2_k);
  if (error_k.empty()) return out;
  std::ranges::sort(error_k);
  for (const double one : error_k) out.error_k.rms += one * one / static_cast<double>(error_k.size());
  out.error_k.rms = std::sqrt(out.error_k.rms);
  out.error_k.percentile_95 = error_k[(error_k.size() - 1) * 95 / 100];
  out.error_k.count = error_k.size();
  out.largest_k = error_k.back();
  return out;
}

}  // namespace radiometry::thermal
