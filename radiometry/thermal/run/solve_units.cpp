// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/run/solve_units.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"
#include "mtf/work/usable_memory.h"
#include "radiometry/light/constants.h"
#include "radiometry/thermal/facet_units.h"
#include "radiometry/thermal/ground.h"
#include "radiometry/weather/sky.h"

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

/// No surface of the scene gets colder: the coldest of air, of the sky as a black body, and of what is given.
double coldest_k(const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  double coldest = *std::ranges::min_element(s.air_k);
  for (const double sky : s.sky_longwave_w_m2) coldest = std::min(coldest, heat::sky_temperature_k(std::max(sky, 0.0)));
  return std::min(coldest, scene.input.given_range_k()[0]);
}

/// What a side of a material gives off for each kelvin, at least: by radiation, and by the film in the weakest wind.
struct Loss {
  double radiation = 0.0, film = 0.0;
  double total() const { return radiation + film; }
};

Loss loss_of(const HeatScene& scene, const Material& material, bool back, double kelvin) {
  const std::vector<double>& wind = scene.surroundings.wind_m_s;
  return {4.0 * material.emissivity(back) * kStefanBoltzmann_w_m2_k4 * std::pow(kelvin, 3),
          forced_coefficient(material.construction.convection, *std::ranges::min_element(wind))};
}

constexpr std::uint32_t kNone = scene::kNone;

/// Where the temperature of each facet comes from.
struct FacetSources {
  std::vector<std::uint32_t> front, back;  ///< receivers; kNone where there is none or it is not asked for
  std::vector<std::uint32_t> given;        ///< facets whose temperature is given
  std::size_t asked_for = 0;               ///< facets
};

FacetSources sources_of(const HeatScene& scene, const Units& units) {
  FacetSources sources;
  sources.front.assign(scene.facets().size(), kNone);
  sources.back = sources.front;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Unit& unit = units.unit[units.unit_of[f]];
    if (!scene.is_seen(f)) continue;
    ++sources.asked_for;
    if (unit.given)
      sources.given.push_back(f);
    else
      sources.front[f] = static_cast<std::uint32_t>(unit.receiver);
    if (unit.has_own_back()) sources.back[f] = static_cast<std::uint32_t>(unit.back_receiver);
  }
  return sources;
}

/// A flux or a film of the wrong size makes such numbers.
[[noreturn]] void refuse_temperature(const HeatScene& scene, const std::vector<double>& front, double time_s) {
  std::uint32_t facet = 0;
  while (!scene.is_seen(facet) || is_temperature(front[facet])) ++facet;
  throw mtf::RuntimeError(mtf::one_line(scene.input.name) + ": region '" + mtf::one_line(scene.region_of(facet).name) +
                          "' comes to " + mtf::significant(front[facet], 4) + " K after " +
                          mtf::significant(time_s / 3600.0, 3) +
                          " h, which no surface does; look at its flux, its film, its emissivity and its convection");
}

/// The part of a change of all temperatures that comes back to a surface by exchange, at most: its share of other
/// surfaces times what they radiate, over what it gives off. None is warmer than `warmest`.
double feedback_ratio(const HeatScene& scene, const Units& units, double warmest) {
  double most = 0.0;
  for_receivers(units, [&](std::size_t receiver, const Unit& unit, const UnitSide& side) {
    if (unit.given || !unit.material) return;
    const Loss loss = loss_of(scene, scene.material[*unit.material], receiver != unit.receiver, warmest);
    const double shares = std::max(0.0, 1.0 - side.sky - side.ground);
    if (loss.radiation > 0.0) most = std::max(most, shares * loss.radiation / loss.total());
  });
  return std::min(most, 0.99);
}

/// The same for a surface that sees nothing but others, of whichever material; at most 0.6, which closed rooms without
/// convection would exceed.
double largest_ratio(const HeatScene& scene, double warmest) {
  double most = 0.0;
  for (const Material& material : scene.material)
    for (const bool back : {false, true})
      if (const Loss loss = loss_of(scene, material, back, warmest); loss.radiation > 0.0)
        most = std::max(most, loss.radiation / loss.total());
  return std::min(most, 0.6);
}

/// Temperatures of all receivers and the light of all patches at the moments of a day are held at once.
void require_room(const HeatScene& scene, const Units& units, const std::vector<Window>& windows) {
  constexpr double kReceiver = 2.0 * sizeof(double), kPatch = 10.0 * sizeof(double);
  std::size_t nodes = 0;
  for (const Window& window : windows) nodes = std::max(nodes, window.last - window.first);
  const double bytes = 2.0 * static_cast<double>(nodes) *
                       (kReceiver * static_cast<double>(units.exchange.receivers()) +
                        kPatch * static_cast<double>(units.exchange.patches()));
  const mtf::UsableMemory memory = mtf::usable_memory();
  constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;
  if (bytes > 0.8 * memory.bytes)
    throw mtf::UsageError(mtf::one_line(scene.input.name) + ": the temperatures of " +
                          std::to_string(units.exchange.receivers()) + " surfaces at the " + std::to_string(nodes) +
                          " nodes of a day would take " + mtf::significant(bytes / kGibibyte, 3) + " GiB, " +
                          memory.whose + " " + mtf::significant(memory.bytes / kGibibyte, 3) +
                          " GiB; ask for a larger tolerance, a longer [time] step, or means of the "
                          "weather: [weather] average = \"5 min\"");
}

constexpr double kSunlit_k = 40.0;  // above the air, for shares of the tolerance; the promise takes the true one

double warmest_air_k(const HeatScene& scene) { return *std::ranges::max_element(scene.surroundings.air_k); }

/// Shares of what is left of the tolerance when exchange passes errors on.
constexpr double kSolverShare = 0.35, kUnitsShare = 0.15, kGroundShare = 0.03, kExchangeShare = 0.25;

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
    mtf::parallel_for_each(static_cast<std::int64_t>(units.unit.size()), 1024, threads, [&](std::size_t i) {
      const Unit& unit = units.unit[i];
      if (unit.given || !scene.is_seen(unit.leader)) return;
      const auto add = [&](std::size_t r, const UnitSide& side) {
        double sum = 0.0;
        for (std::uint64_t e = rows.first[r]; e < rows.first[r + 1]; ++e)
          sum += rows.value[e] * rows.value[e] * variance[rows.column[e]];
        worst[i] = std::max(worst[i], side.emissivity * std::sqrt(sum));
      };
      add(unit.receiver, unit.front);
      if (unit.back) add(unit.back_receiver, *unit.back);
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

double least_loss_w_m2_k(const HeatScene& scene) {
  const double coldest = coldest_k(scene);
  double least = std::numeric_limits<double>::infinity();
  for (const Material& material : scene.material)
    for (const bool back : {false, true}) least = std::min(least, loss_of(scene, material, back, coldest).total());
  return std::isfinite(least) && least > 0.0 ? least : 1e-3;
}

double units_tolerance_w_m2(const HeatScene& scene, double tolerance_k) {
  const double left_k = tolerance_k * (1.0 - largest_ratio(scene, warmest_air_k(scene) + kSunlit_k));
  return kUnitsShare * left_k * least_loss_w_m2_k(scene);
}

UnitsRun solve_units(const HeatScene& scene, const Units& units, const HeatOptions& options, const HeatOutputs& output,
                     const HeatProgress& progress) {
  const mtf::Stopwatch watch;
  const Surroundings& s = scene.surroundings;
  const double loss = least_loss_w_m2_k(scene);
  double warmest = warmest_air_k(scene);
  UnitsRun solved;
  const double ratio = feedback_ratio(scene, units, warmest + kSunlit_k);
  const double room_k = options.tolerance_k * (1.0 - ratio);
  const std::vector<Window> windows = windows_of(s);
  require_room(scene, units, windows);
  const Ground ground = ground_of(scene, kGroundShare * room_k);
  HeatBatches batches(scene, units, ground.light, kSolverShare * room_k, options.threads);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> front(scene.facets().size(), kUnknown),
      back(units.has_sheets() ? scene.facets().size() : 0, kUnknown);
  const FacetSources sources = sources_of(scene, units);
  const auto emit = [&](std::size_t node) {
    constexpr std::int64_t kFacetsAtOnce = 16384;
    mtf::parallel_for_each(static_cast<std::int64_t>(front.size()), kFacetsAtOnce, options.threads, [&](std::size_t f) {
      if (sources.front[f] != kNone) front[f] = batches.receiver_k(node, sources.front[f]);
      if (!back.empty() && sources.back[f] != kNone) back[f] = batches.receiver_k(node, sources.back[f]);
    });
    for (const std::uint32_t f : sources.given) front[f] = scene.given_k(f, s.time_s[node]);
    std::size_t plausible = 0;
    for (const double kelvin : front) {
      plausible += is_temperature(kelvin) ? 1 : 0;
      warmest = kelvin > warmest ? kelvin : warmest;
    }
    if (plausible != sources.asked_for) refuse_temperature(scene, front, s.time_s[node]);
    output({s.time_s[node], front, back});
    ++solved.outputs;
  };
  std::size_t first = 0;
  if (const Checkpoint* from = options.from) {
    first = from->windows;
    if (first == 0 || first > windows.size() || from->outputs > s.outputs.size() ||
        (from->outputs > 0 && s.outputs[from->outputs - 1] > windows[first - 1].last))
      damaged_checkpoint();
    batches.restore(from->batches, windows[first - 1]);
    solved.outputs = from->outputs;
    solved.promised.exchange_k = from->exchange_k;
    if (options.seen) solved.left_out = from->left_out;
    solved.iterations = from->iterations;
    solved.view_spread = from->view_spread;
    warmest = from->warmest_k;
  }
  const auto checkpoint = [&](std::size_t w) {
    return Checkpoint{w,       solved.outputs,    solved.promised.exchange_k, solved.left_out.value_or(LeftOut{}),
                      warmest, solved.iterations, solved.view_spread,         batches.save()};
  };
  mtf::Stopwatch kept;
  auto next = s.outputs.begin() + static_cast<std::ptrdiff_t>(solved.outputs);
  for (std::size_t w = first; w < windows.size() && next != s.outputs.end(); ++w) {
    if (w > first && options.go_on && !options.go_on()) {
      solved.checkpoint = checkpoint(w);
      break;
    }
    if (w > first && options.keep && kept.ms() >= 1e3 * options.keep_every_s) {
      options.keep(checkpoint(w));
      kept = mtf::Stopwatch();
    }
    progress("heat", static_cast<double>(w) / static_cast<double>(windows.size()));
    const Relaxed relaxed = batches.solve(windows[w], w == 0, kExchangeShare * room_k, loss, ratio);
    solved.iterations = std::max(solved.iterations, relaxed.iterations);
    solved.promised.exchange_k = std::max(solved.promised.exchange_k, relaxed.error_k);
    if (w == 0 && !scene.seen.empty())
      solved.left_out = left_out(scene, units, batches, windows[w], loss, options.threads);
    if (w == 0) solved.view_spread = view_spread(scene, units, ground.light, batches, windows[w], options, loss);
    for (; next != s.outputs.end() && *next <= windows[w].last; ++next) emit(*next);
  }

  solved.promised.feedback = 1.0 / (1.0 - feedback_ratio(scene, units, warmest));
  solved.materials = batches.materials();
  for (const MaterialRun& run : solved.materials)
    if (run.promised.total_k() > solved.promised.solver.total_k()) solved.promised.solver = run.promised;
  if (ground.run) {
    solved.promised.ground_k = ground.run->promised.total_k();
    solved.materials.push_back(*ground.run);
  }
  solved.promised.units_k = units.bound_w_m2 / loss;
  solved.ms = watch.ms();
  return solved;
}

}  // namespace radiometry::thermal
