// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/sample_units.h"

#include <algorithm>

namespace radiometry::thermal {
namespace {

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

std::vector<bool> sampled_units(const Units& units, const HeatScene& scene) {
  const Surroundings& s = scene.surroundings;
  std::vector<std::vector<std::pair<double, std::uint32_t>>> of_material;
  std::vector<double> direct(units.sun.directions, 0.0);
  for (std::size_t k = 0; k + 1 < s.nodes(); ++k)
    if (s.shadow_entry[k] >= 0)
      for (const int entry : {s.shadow_entry[k], s.shadow_entry[k] + 1})
        direct[static_cast<std::size_t>(entry)] =
            std::max({direct[static_cast<std::size_t>(entry)], s.direct_w_m2[k], s.direct_w_m2[k + 1]});
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
