// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "mtf/error.h"
#include "radiometry/scene/views.h"

namespace radiometry::scene {
namespace {

void check(const Views& views, std::span<const double> area, std::span<const std::uint32_t> set_of, std::size_t sets,
           std::span<const std::uint32_t> patch_of, std::size_t patches) {
  const auto refuse = [](const std::string& what) { throw mtf::UsageError("combined_views: " + what); };
  if (views.patches.rows() != views.size()) refuse("the views have no shares of patches.");
  if (area.size() != views.size() || set_of.size() != views.size())
    refuse("there are " + std::to_string(views.size()) + " receivers, areas of " + std::to_string(area.size()) +
           " and sets of " + std::to_string(set_of.size()) + ".");
  if (std::any_of(set_of.begin(), set_of.end(), [sets](std::uint32_t s) { return s >= sets; }) ||
      std::any_of(patch_of.begin(), patch_of.end(), [patches](std::uint32_t p) { return p >= patches; }))
    refuse("the number of a set or patch is not below their count.");
  if (std::any_of(views.patches.column.begin(), views.patches.column.end(),
                  [&](std::uint32_t c) { return c >= patch_of.size(); }))
    refuse("the views name a patch beyond the " + std::to_string(patch_of.size()) + " that are told.");
}

/// Members of each set, in rising order.
std::vector<std::vector<std::uint32_t>> members_of(std::span<const std::uint32_t> set_of, std::size_t sets) {
  std::vector<std::vector<std::uint32_t>> members(sets);
  for (std::uint32_t i = 0; i < set_of.size(); ++i) members[set_of[i]].push_back(i);
  return members;
}

}  // namespace

Views combined_views(const Views& views, std::span<const double> area, std::span<const std::uint32_t> set_of,
                     std::size_t sets, std::span<const std::uint32_t> patch_of, std::size_t patches) {
  check(views, area, set_of, sets, patch_of, patches);
  const auto rings = static_cast<std::size_t>(views.rings);
  Views combined{.rings = views.rings,
                 .sky = std::vector<double>(sets * rings, 0.0),
                 .ground = std::vector<double>(sets, 0.0),
                 .surfaces = std::vector<double>(sets, 0.0),
                 .rays = std::vector<double>(sets, 0.0)};
  std::vector<double> share(patches, 0.0);  // of the set at hand
  std::vector<std::uint32_t> seen;
  const std::vector<std::vector<std::uint32_t>> members = members_of(set_of, sets);
  for (std::size_t set = 0; set < sets; ++set) {
    double total = 0.0;
    for (const std::uint32_t i : members[set]) total += area[i];
    if (!(total > 0.0)) throw mtf::UsageError("combined_views: set " + std::to_string(set) + " has no member.");
    for (const std::uint32_t i : members[set]) {
      const double weight = area[i] / total;
      for (std::size_t r = 0; r < rings; ++r) combined.sky[set * rings + r] += weight * views.sky[i * rings + r];
      combined.ground[set] += weight * views.ground[i];
      combined.surfaces[set] += weight * views.surfaces[i];
      combined.rays[set] += views.rays[i];
      for (std::uint64_t e = views.patches.first[i]; e < views.patches.first[i + 1]; ++e) {
        double& sum = share[patch_of[views.patches.column[e]]];
        if (sum == 0.0) seen.push_back(patch_of[views.patches.column[e]]);
        sum += weight * views.patches.value[e];
      }
    }
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    for (const std::uint32_t patch : seen) {
      combined.patches.column.push_back(patch);
      combined.patches.value.push_back(share[patch]);
      share[patch] = 0.0;
    }
    seen.clear();
    combined.patches.first.push_back(combined.patches.column.size());
  }
  return combined;
}

}  // namespace radiometry::scene
