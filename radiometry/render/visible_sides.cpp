// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visible_sides.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include "mtf/parallel.h"
#include "radiometry/scene/sun_visibility.h"
#include "radiometry/scene/table_error.h"

namespace radiometry::render {

VisibleSides::VisibleSides(const RenderScene& scene, const Patches& patches, const Options& options)
    : scene_(scene), patches_(patches), options_(options), number_(2 * scene.facets().size(), scene::kNone) {}

VisibleSides::VisibleSides(const RenderScene& scene, const Patches& patches, const VisibleSides& known)
    : scene_(scene),
      patches_(patches),
      options_(known.options_),
      number_(known.number_),
      side_(known.side_),
      shown_(known.shown_),
      sun_cosine_(known.sun_cosine_),
      sun_share_(known.sun_share_),
      first_(known.first_),
      source_(known.source_),
      share_(known.share_) {
  if (!same_direction(scene.sun, known.scene_.sun)) set_sun(0);
}

/// Those that have no number yet; the others are shown.
std::vector<std::uint32_t> VisibleSides::unknown(const VisibleParts& parts) {
  std::vector<std::uint32_t> fresh;
  std::fill(shown_.begin(), shown_.end(), std::uint8_t{0});
  std::mutex lock;
  mtf::parallel_for(static_cast<std::int64_t>(parts.band.size()), 1, options_.threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      std::vector<std::uint32_t> here;
                      const auto take = [&](std::uint32_t side) {
                        const std::uint32_t number = number_[side];
                        if (number == scene::kNone)
                          here.push_back(side);
                        else
                          std::atomic_ref(shown_[number]).store(1, std::memory_order_relaxed);
                      };
                      for (auto band = static_cast<std::size_t>(begin); band < static_cast<std::size_t>(end); ++band) {
                        for (const SamplePart& part : parts.band[band])
                          if (part.side != scene::kNone) take(part.side);
                        for (const SampleRun& run : parts.runs[band]) take(run.side);
                      }
                      if (here.empty()) return;
                      std::sort(here.begin(), here.end());
                      here.erase(std::unique(here.begin(), here.end()), here.end());
                      const std::scoped_lock guard(lock);
                      fresh.insert(fresh.end(), here.begin(), here.end());
                    });
  return fresh;
}

std::size_t VisibleSides::add(const VisibleParts& parts) { return add(unknown(parts)); }

std::size_t VisibleSides::add(std::vector<std::uint32_t> fresh) {
  std::erase_if(fresh, [&](std::uint32_t side) {
    if (side != scene::kNone && number_[side] == scene::kNone) return false;
    if (side != scene::kNone) shown_[number_[side]] = 1;
    return true;
  });
  // In the order of sides, so that what lies together in space lies together here.
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
  for (const std::uint32_t side : fresh) {
    number_[side] = static_cast<std::uint32_t>(side_.size());
    side_.push_back(side);
  }
  shown_.resize(side_.size(), 1);
  set_sun(side_.size() - fresh.size());
  if (options_.views)
    trace(fresh, 0, first_, source_, share_);
  else
    first_.resize(side_.size() + 1, 0);
  return fresh.size();
}

void VisibleSides::take_over(const VisibleSides& other) {
  for (std::size_t n = 0; n < other.size(); ++n) {
    std::uint32_t& number = number_[other.side_[n]];
    if (number != scene::kNone) continue;
    number = static_cast<std::uint32_t>(side_.size());
    side_.push_back(other.side_[n]);
    shown_.push_back(0);
    sun_cosine_.push_back(other.sun_cosine_[n]);
    sun_share_.push_back(other.sun_share_[n]);
    const Light light = other.light(n);
    source_.insert(source_.end(), light.source.begin(), light.source.end());
    share_.insert(share_.end(), light.share.begin(), light.share.end());
    first_.push_back(source_.size());
  }
}

void VisibleSides::set_sun(std::size_t first) {
  constexpr int kPoints = 16;
  sun_cosine_.resize(side_.size());
  sun_share_.resize(side_.size());
  std::fill(sun_cosine_.begin() + static_cast<std::ptrdiff_t>(first), sun_cosine_.end(), 0.0F);
  std::fill(sun_share_.begin() + static_cast<std::ptrdiff_t>(first), sun_share_.end(), 0.0F);
  if (!scene_.sun) return;
  const Vector& to_sun = scene_.sun->to_sun;
  const auto count = static_cast<std::int64_t>(side_.size() - first);
  mtf::parallel_for(count, 256, options_.threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::size_t n = first + static_cast<std::size_t>(begin); n < first + static_cast<std::size_t>(end); ++n) {
      const scene::Side side{side_[n] / 2, side_[n] % 2 == 1};
      const double up = scene::dot(scene_.facets().facet[side.facet].normal, to_sun);
      const double cosine = (side.back ? -up : up) / scene::length(to_sun);
      if (!(cosine > 0.0)) continue;
      // One at a time, so that the points are those of the side, whatever others there are.
      const scene::SunVisibility lit = sun_visibility(*scene_.rays, std::span(&side, 1), std::span(&to_sun, 1),
                                                      {.points = kPoints, .seed = index(side), .threads = 1});
      sun_cosine_[n] = static_cast<float>(cosine);
      sun_share_[n] = static_cast<float>(lit.share(0, 0));
    }
  });
}

void VisibleSides::trace(std::span<const std::uint32_t> of, std::uint64_t seed, std::vector<std::size_t>& first,
                         std::vector<std::uint32_t>& source, std::vector<float>& share) const {
  if (of.empty()) return;
  std::vector<scene::Side> sides;
  for (const std::uint32_t side : of) sides.push_back({side / 2, side % 2 == 1});
  const scene::Views views =
      scene::views(*scene_.rays, scene::single_sides(std::move(sides)), patches_.patch_of, patches_.size(),
                   {.rings = options_.rings,
                    .rays = options_.rays,
                    .seed = seed,
                    .threads = options_.threads,
                    .rays_of_side = true});
  const auto rings = static_cast<std::size_t>(options_.rings);
  const auto add = [&](std::size_t from, double part) {
    if (part == 0.0) return;
    source.push_back(static_cast<std::uint32_t>(from));
    share.push_back(static_cast<float>(part));
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t r = 0; r < rings; ++r) add(r, views.sky[i * rings + r]);
    add(rings, views.ground[i]);
    for (std::uint64_t e = views.patches.first[i]; e < views.patches.first[i + 1]; ++e)
      add(rings + 1 + views.patches.column[e], views.patches.value[e]);
    first.push_back(source.size());
  }
}

void VisibleSides::trace_again(int rays) {
  options_.rays = rays;
  first_.assign(1, 0), source_.clear(), share_.clear();
  trace(side_, 0, first_, source_, share_);
}

VisibleSides::OtherViews VisibleSides::other_views(std::size_t count) const {
  std::vector<std::size_t> shown;
  for (std::size_t n = 0; n < size(); ++n)
    if (shown_[n] != 0) shown.push_back(n);
  // Whatever order they were numbered in.
  std::sort(shown.begin(), shown.end(), [&](std::size_t a, std::size_t b) { return side_[a] < side_[b]; });
  OtherViews other;
  std::vector<std::uint32_t> sides;
  for (std::size_t k = 0; k < std::min(count, shown.size()); ++k) {
    other.number.push_back(shown[k * shown.size() / std::min(count, shown.size())]);
    sides.push_back(side_[other.number.back()]);
  }
  trace(sides, scene::kOtherSet, other.first, other.source, other.share);
  return other;
}

}  // namespace radiometry::render
