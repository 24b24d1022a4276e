// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/sample_units.h"

#include <algorithm>

namespace apps::scene {
namespace {

constexpr std::size_t kOfPatch = 6, kOfMaterial = 64, kWorthwhile = 4;

/// The largest change of direct light between neighbouring directions, W/m2 absorbed.
double largest_jump(const Unit& unit, const Units& units, const Surroundings& s, const std::vector<double>& direct) {
  double most = 0.0, before = 0.0;
  const std::uint8_t* lit = units.sun.lit.data() + unit.front.sun_row * units.sun.directions;
  for (std::size_t d = 0; d < units.sun.directions; ++d) {
    const double here = unit.front.absorptance * direct[d] *
                        std::max(0.0, radiometry::scene::dot(unit.front.normal, s.shadow_to_sun[d])) * lit[d] /
                        units.sun.points;
    most = std::max(most, std::abs(here - before));
    before = here;
  }
  return most;
}

}  // namespace

std::vector<bool> sampled_units(const Units& units, const Surroundings& s) {
  std::vector<std::vector<std::uint32_t>> of_patch(units.exchange.patches());
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
    ++solved;
    for (std::size_t r = unit.receiver; r <= unit.receiver + (unit.has_own_back() ? 1 : 0); ++r)
      of_patch[units.exchange.patch_of[r]].push_back(i);
    of_material.resize(std::max<std::size_t>(of_material.size(), *unit.material + 1));
    of_material[*unit.material].emplace_back(-largest_jump(unit, units, s, direct), i);
  }
  std::vector<bool> sampled(units.unit.size(), false);
  std::size_t count = 0;
  const auto take = [&](std::uint32_t i) {
    count += sampled[i] ? 0 : 1;
    sampled[i] = true;
  };
  for (const std::vector<std::uint32_t>& of : of_patch)
    for (std::size_t j = 0; j < std::min(kOfPatch, of.size()); ++j)
      take(of[(2 * j + 1) * of.size() / (2 * std::min(kOfPatch, of.size()))]);
  for (auto& of : of_material) {
    const std::size_t some = std::min(kOfMaterial, of.size());
    std::partial_sort(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(some), of.end());
    for (std::size_t j = 0; j < some; ++j) take(of[j].second);
  }
  if (kWorthwhile * count < solved) return sampled;
  for (std::size_t i = 0; i < sampled.size(); ++i) sampled[i] = !units.unit[i].given;
  return sampled;
}

}  // namespace apps::scene
