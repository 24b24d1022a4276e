// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/facet_units.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/views.h"
#include "radiometry/thermal/heat_scene.h"
#include "radiometry/thermal/unit_flux.h"
#include "radiometry/weather/sky.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
using geometry::Side;

/// The number of rays of each side, empty where all have `rays`: what no one asks for is only seen by others, patch by
/// patch, so that few rays do for each.
std::vector<int> rays_of(const HeatScene& scene, const Sides& all, int rays) {
  constexpr int kFewer = 16, kLeast = 8;
  std::vector<int> of_side;
  if (!scene.seen.empty())
    for (const Side side : all.sides)
      of_side.push_back(scene.is_seen(side.facet) ? rays : std::min(rays, std::max(kLeast, rays / kFewer)));
  return of_side;
}

/// Whether no ray from a side left the scene, nor met anything but the inside of the solid that covers it: then it sees
/// its own patch alone.
std::vector<bool> covered_sides(const geometry::Views& seen) {
  std::vector<bool> covered(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::uint64_t first = seen.patches.first[i], count = seen.patches.first[i + 1] - first;
    covered[i] = seen.ground[i] == 0.0 && seen.sky_share(i) == 0.0 && count == 1 && seen.patches.column[first] == i;
  }
  return covered;
}

/// Shadows of the sides that see any sky; the others are dark.
geometry::SunVisibility sun_of(const HeatScene& scene, const Sides& all, const geometry::Views& seen,
                               const geometry::SunOptions& options) {
  const std::vector<Side>& sides = all.sides;
  std::vector<Side> open;
  std::vector<std::size_t> row;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (seen.sky_share(i) > 0.0) {
      open.push_back(sides[i]);
      row.push_back(i);
    }
  const std::vector<geometry::Vector>& to_sun = scene.surroundings.shadow_to_sun;
  const geometry::SunVisibility traced = sun_visibility(scene.rays, open, to_sun, options);
  geometry::SunVisibility sun{options.points, to_sun.size(),
                              std::vector<std::uint8_t>(sides.size() * to_sun.size(), 0)};
  for (std::size_t i = 0; i < row.size(); ++i)
    std::copy_n(traced.lit.begin() + static_cast<std::ptrdiff_t>(i * to_sun.size()), to_sun.size(),
                sun.lit.begin() + static_cast<std::ptrdiff_t>(row[i] * to_sun.size()));
  return sun;
}

/// Throws UsageError where the table of shadows has no room: it has a byte, and classes have four, for each side and
/// direction.
void require_room(const HeatScene& scene, const Sides& all) {
  const std::size_t sides = all.sides.size();
  constexpr double kMost = 4.0 * 1024 * 1024 * 1024;
  const double directions = static_cast<double>(scene.surroundings.shadow_to_sun.size());
  const double bytes = 5.0 * static_cast<double>(sides) * directions;
  if (bytes > kMost)
    throw mtf::UsageError(mtf::one_line(scene.input.name) + ": the table of shadows of " + std::to_string(sides) +
                          " surfaces and " + mtf::significant(directions, 6) + " directions of the sun would take " +
                          mtf::significant(bytes / (1024.0 * 1024 * 1024), 3) +
                          " GiB; shorten [time], or ask for fewer directions a day (--sun-directions)");
}

/// Steps of the vertical component of the normal that buoyancy depends on, and of a temperature that is given, in K:
/// none is above 3000 K.
constexpr std::uint32_t kTilts = 4096;

/// Facets of a table whose mean temperatures are within 1 K radiate alike: the step of a facet's.
std::uint32_t temperature_step(const HeatScene& scene, std::uint32_t facet) {
  constexpr double kStep_k = 1.0;
  const auto& table = scene.region_of(facet).table;
  if (!table) return 0;
  double sum = 0.0;
  for (std::size_t i = facet; i < table->front_k.size(); i += table->facets)
    sum += static_cast<double>(table->front_k[i]);
  const double mean = sum * static_cast<double>(table->facets) / static_cast<double>(table->front_k.size());
  return static_cast<std::uint32_t>(std::min(mean / kStep_k, kTilts - 1.0));
}

/// What decides beside the view: region of given temperature or material, and the tilt where convection depends on it.
std::vector<geometry::SideFinish> finishes_of(const HeatScene& scene, const std::vector<Side>& sides) {
  std::vector<geometry::SideFinish> finishes;
  for (const Side side : sides) {
    const Region& region = scene.region_of(side.facet);
    geometry::SideFinish finish;
    if (region.material) {
      const Material& surface = scene.material[*region.material];
      finish.solar_absorptance = surface.absorptance(side.back);
      finish.emissivity = surface.emissivity(side.back);
      finish.key = static_cast<std::uint32_t>(*region.material) * kTilts;
      if (std::holds_alternative<heat::Tarp>(surface.construction.convection))
        finish.key +=
            static_cast<std::uint32_t>(std::lround(500.0 * (1.0 + scene.facets().facet[side.facet].normal[2])));
    }
    if (region.is_given())
      finish.key = kTilts * static_cast<std::uint32_t>(scene.material.size() + scene.input.region_of[side.facet]) +
                   temperature_step(scene, side.facet);
    finish.key = 2 * finish.key + (side.back ? 1 : 0);
    finishes.push_back(finish);
  }
  return finishes;
}

/// The largest direct irradiance of the run from each direction of the table of shadows, W/m2.
std::vector<double> largest_direct(const Surroundings& s) {
  std::vector<double> direct(s.shadow_to_sun.size(), 0.0);
  for (std::size_t k = 0; k + 1 < s.nodes(); ++k)
    if (s.shadow_entry[k] >= 0)
      for (const int entry : {s.shadow_entry[k], s.shadow_entry[k] + 1}) {
        double& most = direct[static_cast<std::size_t>(entry)];
        most = std::max({most, s.direct_w_m2[k], s.direct_w_m2[k + 1]});
      }
  return direct;
}

/// Largest irradiances of the run. Long-wave shares sum to 1, so that only differences matter, here those from the sky:
/// it is colder than the air; ground and other surfaces may be warmer than the air, by as much as a given temperature
/// or an inside is, or, where only the sun heats them, as the sky is colder. What facets of a unit see differently is
/// measured afterwards (ViewSpread).
geometry::FluxAmplitudes amplitudes_of(const HeatScene& scene, int rings) {
  const Surroundings& s = scene.surroundings;
  geometry::FluxAmplitudes a;
  a.direct = largest_direct(s);
  double colder = 0.0;
  for (std::size_t k = 0; k < s.nodes(); ++k)
    colder = std::max(colder, std::abs(heat::blackbody_w_m2(s.air_k[k]) - s.sky_longwave_w_m2[k]));
  double warmer = colder;
  const auto [coldest, warmest] = std::minmax_element(s.air_k.begin(), s.air_k.end());
  if (const auto [least, most] = scene.input.given_range_k(); least <= most)
    warmer = std::max({warmer, heat::blackbody_w_m2(most) - heat::blackbody_w_m2(*coldest),
                       heat::blackbody_w_m2(*warmest) - heat::blackbody_w_m2(least)});
  a.sky_solar.assign(static_cast<std::size_t>(rings), *std::ranges::max_element(s.diffuse_w_m2));
  a.sky_longwave.assign(static_cast<std::size_t>(rings), 0.0);
  a.ground_solar = a.surfaces_solar = 0.3 * *std::ranges::max_element(s.global_w_m2);
  a.ground_longwave = a.surfaces_longwave = colder + warmer;
  return a;
}

/// The facets of a unit have the same class in front and, sheets, at the back.
struct Grouping {
  std::vector<std::uint32_t> unit_of;  ///< of each facet
  std::vector<std::uint32_t> leader;   ///< facet of each unit
};

Grouping group(const Sides& sides, const geometry::Classes& classes, std::size_t facets) {
  Grouping g;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
  for (std::uint32_t f = 0; f < facets; ++f) {
    const std::uint32_t back = sides.back_of[f];
    const std::pair key{classes.class_of[f], back == geometry::kNone ? geometry::kNone : classes.class_of[back]};
    const auto [at, fresh] = known.try_emplace(key, static_cast<std::uint32_t>(g.leader.size()));
    if (fresh) g.leader.push_back(f);
    g.unit_of.push_back(at->second);
  }
  return g;
}

/// Puts units of one material together, and those with similar shadows side by side: they share steps.
void sort_units(Grouping& g, const HeatScene& scene, const geometry::SunVisibility& sun) {
  std::vector<std::uint32_t> order(g.leader.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto rank = [&](std::uint32_t facet) {
    const Region& region = scene.region_of(facet);
    return region.is_given() ? scene.material.size() : scene.material_of(facet);
  };
  const auto shadows = [&](std::uint32_t facet) {
    return std::span(sun.lit).subspan(facet * sun.directions, sun.directions);
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t fa = g.leader[a], fb = g.leader[b];
    if (rank(fa) != rank(fb)) return rank(fa) < rank(fb);
    const auto sa = shadows(fa), sb = shadows(fb);
    const auto compared = std::lexicographical_compare_three_way(sa.begin(), sa.end(), sb.begin(), sb.end());
    return compared != 0 ? compared < 0 : a < b;
  });
  std::vector<std::uint32_t> place(order.size()), leader(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    leader[i] = g.leader[order[i]];
  }
  for (std::uint32_t& unit : g.unit_of) unit = place[unit];
  g.leader = std::move(leader);
}

/// Patches by flux; no patch has two finishes, so room for two patches of each is made.
geometry::Classes patches_of(const HeatScene& scene, const std::vector<Side>& sides,
                             const std::vector<geometry::SideFinish>& finish, const geometry::Views& seen,
                             const geometry::SunVisibility& sun, const geometry::FluxAmplitudes& amplitudes,
                             std::size_t most, int threads) {
  std::set<std::uint32_t> finishes;
  for (const geometry::SideFinish& one : finish) finishes.insert(one.key);
  return geometry::patches_of(scene.facets(), sides, finish, seen, sun, scene.surroundings.shadow_to_sun, amplitudes,
                              std::max(most, 2 * finishes.size()), threads);
}

/// Two facets that see equal shares of other surfaces may see warmer and colder ones. So surfaces are sorted into a few
/// kinds of like flux, and the keys get the shares of the view that each kind has, in steps: of the tolerance, but no
/// finer than sampling resolves. What remains is measured (ViewSpread).
void add_seen_kinds(const HeatScene& scene, const std::vector<Side>& sides, const geometry::Views& seen,
                    const geometry::SunVisibility& sun, const geometry::FluxAmplitudes& amplitudes,
                    double tolerance_w_m2, const HeatOptions& options, std::vector<geometry::SideFinish>& finish) {
  constexpr std::size_t kKinds = 24;
  const geometry::Classes kinds = patches_of(scene, sides, finish, seen, sun, amplitudes, kKinds, options.threads);
  const double resolved = 0.25 / std::sqrt(static_cast<double>(options.rays_of(scene.facets().size())));
  const double step = std::max(tolerance_w_m2 / std::max(amplitudes.surfaces_longwave, 1.0), resolved);
  std::vector<std::vector<std::uint32_t>> key(finish.size());
  mtf::parallel_for(static_cast<std::int64_t>(finish.size()), 4096, options.threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      std::vector<double> share(kinds.size());
                      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                        std::fill(share.begin(), share.end(), 0.0);
                        for (std::uint64_t e = seen.patches.first[i]; e < seen.patches.first[i + 1]; ++e)
                          share[kinds.class_of[seen.patches.column[e]]] += seen.patches.value[e];
                        key[i] = {finish[i].key};
                        for (std::uint32_t kind = 0; kind < share.size(); ++kind) {
                          const auto steps = static_cast<std::uint32_t>(std::lround(share[kind] / step));
                          if (steps > 0) key[i].insert(key[i].end(), {kind, steps});
                        }
                      }
                    });
  std::map<std::vector<std::uint32_t>, std::uint32_t> known;
  for (std::size_t i = 0; i < finish.size(); ++i)
    finish[i].key = known.try_emplace(std::move(key[i]), static_cast<std::uint32_t>(known.size())).first->second;
}

/// Covered sides of one finish are one class, whatever else is merged.
void merge_covered(const std::vector<geometry::SideFinish>& finish, const std::vector<bool>& covered,
                   geometry::Classes& classes) {
  std::map<std::uint32_t, std::uint32_t> of_finish;
  std::vector<std::uint32_t> renumbered(classes.size(), geometry::kNone);
  geometry::Classes merged{.bound_w_m2 = classes.bound_w_m2};
  for (std::uint32_t i = 0; i < covered.size(); ++i) {
    std::uint32_t& number = covered[i] ? of_finish.try_emplace(finish[i].key, geometry::kNone).first->second
                                       : renumbered[classes.class_of[i]];
    if (number == geometry::kNone) {
      number = static_cast<std::uint32_t>(merged.leader.size());
      merged.leader.push_back(i);
    }
    merged.class_of.push_back(number);
  }
  classes = std::move(merged);
}

/// Entries of a table for some of its rows.
geometry::Views rows_of(const geometry::Views& views, const std::vector<std::uint32_t>& rows) {
  geometry::Views some;
  some.rings = views.rings;
  some.rays = views.rays;
  const auto rings = static_cast<std::size_t>(views.rings);
  for (const std::uint32_t row : rows) {
    const auto ring = views.sky.begin() + static_cast<std::ptrdiff_t>(row * rings);
    some.sky.insert(some.sky.end(), ring, ring + views.rings);
    some.ground.push_back(views.ground[row]);
    some.surfaces.push_back(views.surfaces[row]);
  }
  return some;
}

geometry::SunVisibility rows_of(const geometry::SunVisibility& sun, const std::vector<std::uint32_t>& rows) {
  geometry::SunVisibility some{sun.points, sun.directions, {}};
  for (const std::uint32_t row : rows) {
    const auto first = sun.lit.begin() + static_cast<std::ptrdiff_t>(row * sun.directions);
    some.lit.insert(some.lit.end(), first, first + static_cast<std::ptrdiff_t>(sun.directions));
  }
  return some;
}

/// The patches that sides have in other units, numbered anew: where more facets are one unit, as covered ones that are
/// seen with others, a patch may have none that leads.
std::vector<std::uint32_t> patches_like(const Units& like, const std::vector<Side>& leaders) {
  std::map<std::uint32_t, std::uint32_t> known;
  std::vector<std::uint32_t> patch_of;
  for (const Side side : leaders)
    patch_of.push_back(
        known.try_emplace(like.patch_of_side[geometry::index(side)], static_cast<std::uint32_t>(known.size()))
            .first->second);
  return patch_of;
}

UnitSide side_of(const HeatScene& scene, const Unit& unit, std::uint32_t facet, bool back, std::size_t sun_row) {
  UnitSide side;
  side.normal = scene.facets().facet[facet].normal;
  if (back)
    for (double& component : side.normal) component = -component;
  side.sun_row = sun_row;
  side.absorptance = unit.material ? scene.material[*unit.material].absorptance(back) : 1.0;
  side.emissivity = unit.material ? scene.material[*unit.material].emissivity(back) : 1.0;
  if (unit.material)
    side.source_w_m2 =
        back ? scene.material[*unit.material].back_source_w_m2 : scene.material[*unit.material].source_w_m2;
  return side;
}

constexpr std::size_t kOfPatch = 6, kOfMaterial = 64, kWorthwhile = 4;
constexpr std::size_t kStandIn = 24;  // of a patch that no one asks for

/// The units to be solved of each patch, in their order.
std::vector<std::vector<std::uint32_t>> units_of_patches(const Units& units) {
  std::vector<std::vector<std::uint32_t>> of_patch(units.exchange.patches());
  for (std::uint32_t i = 0; i < units.unit.size(); ++i) {
    const Unit& unit = units.unit[i];
    if (unit.given) continue;
    of_patch[units.exchange.patch_of[unit.receiver]].push_back(i);
    if (unit.has_own_back()) of_patch[units.exchange.patch_of[unit.back_receiver]].push_back(i);
  }
  return of_patch;
}

/// Calls `take` for so many of a list, evenly through it.
template <class Take>
void for_some_of(const std::vector<std::uint32_t>& list, std::size_t count, const Take& take) {
  count = std::min(count, list.size());
  for (std::size_t j = 0; j < count; ++j) take(list[(2 * j + 1) * list.size() / (2 * count)]);
}

/// The largest change of direct light between neighbouring directions, W/m2 absorbed.
double largest_jump(const Unit& unit, const Units& units, const Surroundings& s, const std::vector<double>& direct) {
  double most = 0.0, before = 0.0;
  const std::uint8_t* lit = units.sun.lit.data() + unit.front.sun_row * units.sun.directions;
  for (std::size_t d = 0; d < units.sun.directions; ++d) {
    const double here = unit.front.absorptance * direct[d] *
                        std::max(0.0, scene::dot(unit.front.normal, s.shadow_to_sun[d])) * lit[d] / units.sun.points;
    most = std::max(most, std::abs(here - before));
    before = here;
  }
  return most;
}

}  // namespace

Sides sides_of(const HeatScene& scene) {
  Sides all;
  const auto facets = static_cast<std::uint32_t>(scene.facets().size());
  all.back_of.assign(facets, geometry::kNone);
  for (std::uint32_t f = 0; f < facets; ++f) all.sides.push_back({f, false});
  for (std::uint32_t f = 0; f < facets; ++f)
    if (const std::uint32_t opposite = scene.opposite_of(f); opposite != geometry::kNone) {
      all.back_of[f] = opposite;
    } else if (scene.is_sheet(f)) {
      all.back_of[f] = static_cast<std::uint32_t>(all.sides.size());
      all.sides.push_back({f, true});
    }
  return all;
}

Units units_of(const HeatScene& scene, const HeatOptions& options, double tolerance_w_m2, const Units* like) {
  const mtf::Stopwatch watch;
  const geometry::Facets& facets = scene.facets();
  const std::vector<geometry::Vector>& to_sun = scene.surroundings.shadow_to_sun;
  const Sides all = sides_of(scene);
  require_room(scene, all);
  std::vector<geometry::SideFinish> finish = finishes_of(scene, all.sides);
  const int rays = options.rays_of(facets.size());
  const std::vector<int> rays_of_side = rays_of(scene, all, rays);
  const geometry::ViewOptions view_options{.rays = rays, .rays_of = rays_of_side, .threads = options.threads};
  const geometry::Receivers single = geometry::single_sides(all.sides);
  std::vector<std::uint32_t> own(all.sides.size());
  std::iota(own.begin(), own.end(), 0U);
  const geometry::Views seen =
      views(scene.rays, single, patches_of_sides(facets, single, own), own.size(), view_options);
  const geometry::SunOptions sun_options{
      .points = options.sun_points, .seed = options.sun_seed, .threads = options.threads};
  Units units;
  units.sun = sun_of(scene, all, seen, sun_options);
  units.rays_ms = watch.ms();

  const mtf::Stopwatch classing;
  const geometry::FluxAmplitudes amplitudes = amplitudes_of(scene, view_options.rings);
  const std::vector<bool> covered = covered_sides(seen);
  // Neither units nor patches hold both what is seen and what is not.
  for (std::size_t i = 0; i < finish.size(); ++i)
    finish[i].key = 4 * finish[i].key + (covered[i] ? 1 : 0) + (scene.is_seen(all.sides[i].facet) ? 0 : 2);
  const std::vector<geometry::SideFinish> plain = finish;
  if (tolerance_w_m2 > 0.0)
    add_seen_kinds(scene, all.sides, seen, units.sun, amplitudes, tolerance_w_m2, options, finish);
  geometry::Classes classes =
      classes_of(facets, all.sides, finish, seen, units.sun, to_sun, amplitudes, tolerance_w_m2, options.threads);
  merge_covered(plain, covered, classes);
  units.bound_w_m2 = classes.bound_w_m2;
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    if (covered[f] && scene.is_seen(f)) units.covered.push_back(f);  // the few rays of others tell less
  Grouping grouping = group(all, classes, facets.size());
  sort_units(grouping, scene, units.sun);
  units.unit_of = grouping.unit_of;

  std::vector<std::uint32_t> leader_rows;  // of receivers, rows of `all`
  std::vector<Side> leaders;
  for (const std::uint32_t facet : grouping.leader) {
    const Region& region = scene.region_of(facet);
    Unit unit;
    unit.leader = facet;
    unit.region = scene.input.region_of[facet];
    if (region.material) unit.material = static_cast<std::uint32_t>(scene.material_of(facet));
    unit.given = region.is_given();
    unit.receiver = leaders.size();
    unit.front = side_of(scene, unit, facet, false, facet);
    leader_rows.push_back(facet);
    leaders.push_back({facet, false});
    const std::uint32_t back = all.back_of[facet];
    unit.paired = scene.opposite_of(facet) != geometry::kNone;
    unit.back_receiver = unit.receiver + 1;
    if (unit.paired) {
      unit.back = side_of(scene, unit, back, false, back);
      unit.back->source_w_m2 = scene.material[*unit.material].back_source_w_m2;
    } else if (back != geometry::kNone) {
      unit.back = side_of(scene, unit, facet, true, back);
      leader_rows.push_back(back);
      leaders.push_back({facet, true});
    }
    units.unit.push_back(unit);
  }

  std::vector<std::uint32_t> receiver_of;  // of each side of `all`
  for (const Side side : all.sides)
    receiver_of.push_back(
        static_cast<std::uint32_t>(units.unit[units.unit_of[side.facet]].receiver + (side.back ? 1 : 0)));
  const geometry::Receivers receivers = geometry::sets_of_sides(all.sides, receiver_of, leaders.size());
  std::vector<geometry::SideFinish> leader_finish;
  for (const std::uint32_t row : leader_rows) leader_finish.push_back(plain[row]);
  std::vector<std::uint32_t> patch_of;
  if (like == nullptr)
    patch_of = patches_of(scene, leaders, leader_finish, rows_of(seen, leader_rows), rows_of(units.sun, leader_rows),
                          amplitudes, options.patches, options.threads)
                   .class_of;
  else
    patch_of = patches_like(*like, leaders);
  const std::size_t patches = 1 + *std::max_element(patch_of.begin(), patch_of.end());
  units.patch_of_side = patches_of_sides(facets, receivers, patch_of);
  std::vector<std::uint32_t> patch_of_row;
  for (const std::uint32_t receiver : receiver_of) patch_of_row.push_back(patch_of[receiver]);
  units.views = combined_views(seen, areas_m2(facets, single), receiver_of, leaders.size(), patch_of_row, patches);
  units.exchange = exchange_of(units.views, areas_m2(facets, receivers), patch_of, patches);
  const auto add_view = [&](UnitSide& side, std::size_t receiver) {
    side.sky = units.views.sky_share(receiver);
    side.ground = units.views.ground[receiver];
  };
  for (std::size_t i = 0; i < units.unit.size(); ++i) {
    Unit& unit = units.unit[i];
    if (unit.paired) unit.back_receiver = units.unit[units.unit_of[scene.opposite_of(grouping.leader[i])]].receiver;
    add_view(unit.front, unit.receiver);
    if (unit.back) add_view(*unit.back, unit.back_receiver);
  }
  units.classes_ms = classing.ms();

  const mtf::Stopwatch errors;
  const std::size_t checked = options.measured(all.sides.size());
  std::vector<std::uint32_t> asked_for;
  for (std::uint32_t i = 0; i < leaders.size(); ++i)
    if (scene.is_seen(leaders[i].facet)) asked_for.push_back(i);
  units.view_error = view_error(scene.rays, receivers, units.views, view_options, checked, asked_for);
  units.sun_error = sun_error(scene.rays, all.sides, sun_checks(scene.surroundings), units.sun, sun_options, checked);
  units.error_ms = errors.ms();
  return units;
}

std::vector<bool> sampled_units(const Units& units, const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  std::vector<std::vector<std::pair<double, std::uint32_t>>> of_material;
  const std::vector<double> direct = largest_direct(s);
  std::size_t solved = 0;
  for (std::uint32_t i = 0; i < units.unit.size(); ++i) {
    const Unit& unit = units.unit[i];
    if (unit.given) continue;
    solved += scene.is_seen(unit.leader) ? 1 : 0;
    of_material.resize(std::max<std::size_t>(of_material.size(), *unit.material + 1));
    of_material[*unit.material].emplace_back(-largest_jump(unit, units, s, direct), i);
  }
  std::vector<bool> sampled(units.unit.size(), false);
  std::size_t count = 0;
  const auto take = [&](std::uint32_t i) {
    count += sampled[i] ? 0 : 1;
    sampled[i] = true;
  };
  for (const std::vector<std::uint32_t>& of : units_of_patches(units)) for_some_of(of, kOfPatch, take);
  for (auto& of : of_material) {
    const std::size_t some = std::min(kOfMaterial, of.size());
    std::partial_sort(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(some), of.end());
    for (std::size_t j = 0; j < some; ++j) take(of[j].second);
  }
  if (kWorthwhile * count < solved) return sampled;
  for (std::size_t i = 0; i < sampled.size(); ++i)
    sampled[i] = sampled[i] || (!units.unit[i].given && scene.is_seen(units.unit[i].leader));
  return sampled;
}

std::vector<bool> solved_units(const Units& units, const HeatScene& scene) {
  std::vector<bool> solved(units.unit.size());
  for (std::size_t i = 0; i < solved.size(); ++i)
    solved[i] = !units.unit[i].given && scene.is_seen(units.unit[i].leader);
  if (scene.seen.empty()) return solved;
  const std::vector<bool> sampled = sampled_units(units, scene);
  for (std::size_t i = 0; i < solved.size(); ++i) solved[i] = solved[i] || sampled[i];
  for (const std::vector<std::uint32_t>& of : units_of_patches(units))
    if (!of.empty() && !scene.is_seen(units.unit[of.front()].leader))
      for_some_of(of, kStandIn, [&](std::uint32_t i) { solved[i] = true; });
  return solved;
}

}  // namespace radiometry::thermal
