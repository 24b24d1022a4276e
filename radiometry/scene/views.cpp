// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "radiometry/scene/tracing/embree_scene.h"
#include "radiometry/scene/tracing/ray_sampling.h"

namespace radiometry::scene {
namespace {

constexpr int kMostRays = 1 << 24;

void check(const Rays& rays, const Receivers& receivers, const ViewOptions& options) {
  const auto refuse = [](const std::string& what, int value, const std::string& range) {
    throw mtf::UsageError("views: " + what + " is " + std::to_string(value) + ", it must be " + range);
  };
  if (options.rings < 1 || options.rings > 90) refuse("the number of rings", options.rings, "1 to 90.");
  if (options.rays < 1 || options.rays > kMostRays) refuse("the number of rays", options.rays, "1 to 16777216.");
  if (!options.rays_of.empty() && options.rays_of.size() != receivers.size())
    throw mtf::UsageError("views: there are " + std::to_string(options.rays_of.size()) + " numbers of rays for " +
                          std::to_string(receivers.size()) + " receivers");
  for (const int of_receiver : options.rays_of)
    if (of_receiver < 1 || of_receiver > kMostRays) refuse("the number of rays", of_receiver, "1 to 16777216.");
  for (const Side& side : receivers.sides)
    if (side.facet >= rays.facets().size())
      throw mtf::UsageError("views: there is no facet " + std::to_string(side.facet));
  for (std::size_t i = 0; i < receivers.size(); ++i)
    if (receivers[i].empty()) throw mtf::UsageError("views: receiver " + std::to_string(i) + " has no side");
}

/// A ray that ended on a facet: the patch of the side it met, and the zone of its direction.
struct HiddenRay {
  std::uint32_t patch;
  int zone;
};

/// The rays of one receiver: how many went to each zone, and those that ended on facets.
struct Sample {
  std::vector<int> sent;
  std::vector<HiddenRay> hidden{};
};

/// The patch that a ray from a side sees when it ends on a triangle: see views.h for insides.
class PatchFinder {
 public:
  PatchFinder(const Facets& facets, std::span<const std::uint32_t> patch_of) : facets_(facets), patch_of_(patch_of) {}
  bool wanted() const { return !patch_of_.empty(); }
  std::uint32_t operator()(Side from, EmbreeScene::FirstTriangle triangle) const {
    const std::uint32_t patch = patch_of_[index({facets_.facet_of[triangle.number], triangle.back})];
    return patch == kNone ? patch_of_[index(from)] : patch;
  }

 private:
  const Facets& facets_;
  std::span<const std::uint32_t> patch_of_;
};

Sample sample(const Rays& rays, std::span<const Side> sides, std::uint64_t receiver, const ZenithRings& rings,
              const PatchFinder& patch_of, const ViewOptions& options) {
  const int count = options.rays_of.empty() ? options.rays : options.rays_of[receiver];
  const EmbreeScene& embree = rays.embree();
  const ReceiverSurface surface(rays.facets(), sides, embree.lift_m());
  const SpreadNumbers<4> numbers(receiver, options.seed);
  Sample sample{.sent = std::vector<int>(static_cast<std::size_t>(rings.rings()) + 1, 0)};
  sample.hidden.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const auto [u, v, p, q] = numbers(static_cast<std::uint64_t>(i));
    const auto [point, normal, side] = surface.at(u, v);
    const Vector direction = cosine_direction(normal, p, q);
    const int zone = rings.zone(direction[2]);
    ++sample.sent[static_cast<std::size_t>(zone)];
    const SingleRay ray = embree.single(point, direction);
    if (!patch_of.wanted()) {
      if (embree.blocked(ray)) sample.hidden.push_back({0, zone});
    } else if (const auto triangle = embree.first_triangle(ray); triangle.number != kNone) {
      sample.hidden.push_back({patch_of(side, triangle), zone});
    }
  }
  return sample;
}

struct PatchShare {
  std::uint32_t patch;
  double share;
};

/// For each zone itself or, where no ray went to it, the nearest one with rays, nearer to the zenith of two: what is
/// hidden of a narrow ring is rather like that of its neighbour than like that of the ground.
std::vector<std::size_t> sampled_zones(std::span<const int> sent) {
  std::vector<std::size_t> nearest(sent.size());
  for (std::size_t z = 0; z < sent.size(); ++z)
    for (std::size_t step = 0;; ++step) {
      const bool above = step <= z && sent[z - step] > 0;
      if (!above && !(z + step < sent.size() && sent[z + step] > 0)) continue;
      nearest[z] = above ? z - step : z + step;
      break;
    }
  return nearest;
}

/// Turns counts into shares: `zones` holds what the receiver would see without obstacles, and gets what it sees. The
/// hidden part of each zone goes to the patches in proportion to the rays; their shares are appended to `row`, patches
/// rising.
void post_stratify(Sample& sample, std::span<double> zones, std::vector<PatchShare>& row) {
  const std::vector<std::size_t> nearest = sampled_zones(sample.sent);
  std::vector<int> hidden(zones.size(), 0);
  for (const HiddenRay& ray : sample.hidden) ++hidden[static_cast<std::size_t>(ray.zone)];
  std::vector<double> weight(zones.size(), 0.0);  // of a ray of the zone
  for (std::size_t z = 0; z < zones.size(); ++z) {
    const std::size_t from = nearest[z];
    weight[from] += zones[z] / sample.sent[from];
    zones[z] *= static_cast<double>(sample.sent[from] - hidden[from]) / sample.sent[from];
  }

  std::ranges::sort(sample.hidden, [](const HiddenRay& a, const HiddenRay& b) {
    return a.patch != b.patch ? a.patch < b.patch : a.zone < b.zone;
  });
  const std::size_t before = row.size();
  for (const HiddenRay& ray : sample.hidden) {
    if (row.size() == before || row.back().patch != ray.patch) row.push_back({ray.patch, 0.0});
    row.back().share += weight[static_cast<std::size_t>(ray.zone)];
  }
}

/// One row for each receiver from the shares of chunks of receivers, which are freed.
SparseRows joined(std::vector<std::vector<PatchShare>>& chunks, const std::vector<std::uint32_t>& row_sizes) {
  SparseRows rows;
  rows.first.reserve(row_sizes.size() + 1);
  for (const std::uint32_t size : row_sizes) rows.first.push_back(rows.first.back() + size);
  rows.column.reserve(rows.first.back());
  rows.value.reserve(rows.first.back());
  for (std::vector<PatchShare>& chunk : chunks) {
    for (const PatchShare& entry : chunk) {
      rows.column.push_back(entry.patch);
      rows.value.push_back(entry.share);
    }
    chunk = {};
  }
  return rows;
}

void check(const Views& views, std::span<const double> area, std::span<const std::uint32_t> set_of, std::size_t sets,
           std::span<const std::uint32_t> patch_of, std::size_t patches) {
  const auto refuse = [](const std::string& what) { throw mtf::UsageError("combined_views: " + what); };
  if (views.patches.rows() != views.size()) refuse("the views have no shares of patches.");
  if (area.size() != views.size() || set_of.size() != views.size())
    refuse("there are " + std::to_string(views.size()) + " receivers, areas of " + std::to_string(area.size()) +
           " and sets of " + std::to_string(set_of.size()) + ".");
  if (std::ranges::any_of(set_of, [sets](std::uint32_t s) { return s >= sets; }) ||
      std::ranges::any_of(patch_of, [patches](std::uint32_t p) { return p >= patches; }))
    refuse("the number of a set or patch is not below their count.");
  if (std::ranges::any_of(views.patches.column, [&](std::uint32_t c) { return c >= patch_of.size(); }))
    refuse("the views name a patch beyond the " + std::to_string(patch_of.size()) + " that are told.");
}

/// Members of each set, in rising order.
std::vector<std::vector<std::uint32_t>> members_of(std::span<const std::uint32_t> set_of, std::size_t sets) {
  std::vector<std::vector<std::uint32_t>> members(sets);
  for (std::uint32_t i = 0; i < set_of.size(); ++i) members[set_of[i]].push_back(i);
  return members;
}

}  // namespace

double cap_share(double cos_tilt, double zenith_rad) {
  const double b = std::clamp(cos_tilt, -1.0, 1.0), sin_tilt = std::sqrt((1.0 - b) * (1.0 + b));
  const double s = std::sin(zenith_rad), c = std::cos(zenith_rad);
  if (b >= s) return b * s * s;
  if (b <= -s) return 0.0;
  const double meets = std::clamp(-(c * b) / (s * sin_tilt), -1.0, 1.0);
  const double share = 0.5 + (-std::asin(std::min(1.0, c / sin_tilt)) + b * s * s * std::acos(meets) -
                              c * std::sqrt(std::max(0.0, (s - b) * (s + b)))) /
                                 std::numbers::pi;
  return std::clamp(share, 0.0, 1.0);
}

ZenithRings::ZenithRings(int rings) {
  for (int r = 1; r <= rings; ++r) {
    zenith_rad_.push_back(0.5 * std::numbers::pi * r / rings);
    cosine_.push_back(r == rings ? 0.0 : std::cos(zenith_rad_.back()));
  }
}

int ZenithRings::zone(double up) const {
  // The horizon itself is sky.
  return static_cast<int>(std::ranges::partition_point(cosine_, [up](double c) { return c > up; }) - cosine_.begin());
}

void ZenithRings::add_shares(double cos_tilt, double weight, std::span<double> zones) const {
  double within = 0.0;
  for (std::size_t r = 0; r < cosine_.size(); ++r) {
    const double share = std::max(within, cap_share(cos_tilt, zenith_rad_[r]));
    zones[r] += weight * (share - within);
    within = share;
  }
  zones[cosine_.size()] += weight * (1.0 - within);
}

double Views::sky_share(std::size_t i) const {
  const auto begin = sky.begin() + static_cast<std::ptrdiff_t>(i * static_cast<std::size_t>(rings));
  return std::accumulate(begin, begin + rings, 0.0);
}

Views views(const Rays& rays, const Receivers& receivers, std::span<const std::uint32_t> patch_of, std::size_t patches,
            const ViewOptions& options) {
  check(rays, receivers, options);
  const Facets& facets = rays.facets();
  if (!patch_of.empty() && patch_of.size() != 2 * facets.size())
    throw mtf::UsageError("views: there are " + std::to_string(patch_of.size()) + " patches of sides and " +
                          std::to_string(2 * facets.size()) + " sides");
  for (const std::uint32_t patch : patch_of)
    if (patch >= patches && patch != kNone)
      throw mtf::UsageError("views: a side belongs to patch " + std::to_string(patch) + " of " +
                            std::to_string(patches));
  for (const Side& side : receivers.sides)
    if (!patch_of.empty() && patch_of[index(side)] == kNone)
      throw mtf::UsageError("views: a received side of facet " + std::to_string(side.facet) + " has no patch");
  const ZenithRings rings(options.rings);
  const PatchFinder finder(facets, patch_of);
  const std::size_t count = receivers.size(), zones = static_cast<std::size_t>(options.rings) + 1;
  Views views{.rings = options.rings,
              .sky = std::vector<double>(count * (zones - 1)),
              .ground = std::vector<double>(count),
              .surfaces = std::vector<double>(count),
              .rays = std::vector<double>(count, options.rays)};
  std::copy(options.rays_of.begin(), options.rays_of.end(), views.rays.begin());
  constexpr std::int64_t kChunk = 256;
  std::vector<std::vector<PatchShare>> chunks(count / kChunk + 1);
  std::vector<std::uint32_t> row_sizes(finder.wanted() ? count : 0);

  mtf::parallel_for(
      static_cast<std::int64_t>(count), kChunk, options.threads, [&](std::int64_t begin, std::int64_t end) {
        std::vector<double> seen(zones);
        std::vector<PatchShare>& rows = chunks[static_cast<std::size_t>(begin / kChunk)];
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          double area = 0.0;
          for (const Side& side : receivers[i]) area += facets.facet[side.facet].area_m2;
          std::ranges::fill(seen, 0.0);
          for (const Side& side : receivers[i]) {
            const Facet& facet = facets.facet[side.facet];
            rings.add_shares(side.back ? -facet.normal[2] : facet.normal[2], facet.area_m2 / area, seen);
          }
          const std::uint64_t own = options.rays_of_side ? index(receivers[i].front()) : i;
          Sample counts = sample(rays, receivers[i], own, rings, finder, options);
          const std::size_t before = rows.size();
          post_stratify(counts, seen, rows);
          std::copy(seen.begin(), seen.end() - 1, views.sky.begin() + static_cast<std::ptrdiff_t>(i * (zones - 1)));
          views.ground[i] = seen.back();
          for (std::size_t e = before; e < rows.size(); ++e) views.surfaces[i] += rows[e].share;
          if (finder.wanted())
            row_sizes[i] = static_cast<std::uint32_t>(rows.size() - before);
          else
            rows.clear();
        }
      });

  if (finder.wanted()) views.patches = joined(chunks, row_sizes);
  return views;
}

Views views(const Rays& rays, const Receivers& receivers, const ViewOptions& options) {
  return views(rays, receivers, {}, 0, options);
}

std::vector<std::uint32_t> patches_of_sides(const Facets& facets, const Receivers& receivers,
                                            std::span<const std::uint32_t> patch_of_receiver) {
  if (patch_of_receiver.size() != receivers.size())
    throw mtf::UsageError("patches_of_sides: there are " + std::to_string(receivers.size()) + " receivers and " +
                          std::to_string(patch_of_receiver.size()) + " patches of receivers");
  std::vector<std::uint32_t> patch_of(2 * facets.size(), kNone);
  for (std::size_t i = 0; i < receivers.size(); ++i)
    for (const Side& side : receivers[i]) patch_of[index(side)] = patch_of_receiver[i];
  for (std::size_t s = 0; s < patch_of.size(); s += 2) {
    if (patch_of[s] == kNone) patch_of[s] = patch_of[s + 1];
    const bool inside = facets.shells[facets.facet[s / 2].shell].outward;
    if (patch_of[s + 1] == kNone && !inside) patch_of[s + 1] = patch_of[s];
    if (patch_of[s] == kNone)
      throw mtf::UsageError("patches_of_sides: neither side of facet " + std::to_string(s / 2) +
                            " belongs to a receiver");
  }
  return patch_of;
}

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
    std::ranges::sort(seen);
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
