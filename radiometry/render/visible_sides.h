// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sides that a camera has seen, numbered as they came: what belongs to a side for all bands is worked out when it
// is first seen, and kept. What was never seen costs nothing. The rays that find the view of a side belong to the side,
// so that its light does not depend on what else was seen before.

#include "radiometry/render/light_sources.h"
#include "radiometry/render/visibility/visible_parts.h"

namespace radiometry::render {

class VisibleSides {
 public:
  struct Options {
    int rings = 9, rays = 64;
    bool views = true;  ///< false where nothing reflects
    int threads = 0;
  };
  /// `scene` and `patches` outlive it.
  VisibleSides(const RenderScene& scene, const Patches& patches, const Options& options);
  /// Those that `known` has, of the same facets and patches, in the sun of `scene`.
  VisibleSides(const RenderScene& scene, const Patches& patches, const VisibleSides& known);

  /// Numbers the sides of these parts that are new; returns how many. They are those that are shown now.
  std::size_t add(const VisibleParts& parts);
  /// The same of single sides (kNone: none), which are shown beside them.
  std::size_t add(std::vector<std::uint32_t> sides);

  /// Numbers the sides that `other` has and these lack, with their views: of the same facets, patches, sun and number
  /// of rays. They are not shown.
  void take_over(const VisibleSides& other);

  std::size_t shown_now() const { return static_cast<std::size_t>(std::count(shown_.begin(), shown_.end(), 1)); }

  /// Of each side.
  int rays() const { return options_.rays; }
  /// Traces the views of all sides anew, and those of sides to come, with so many rays.
  void trace_again(int rays);
  /// At most `count` of the sides that are shown, evenly, as other rays see them.
  struct OtherViews {
    std::vector<std::size_t> number;
    std::vector<std::size_t> first{0};
    std::vector<std::uint32_t> source;
    std::vector<float> share;
  };
  OtherViews other_views(std::size_t count) const;

  std::size_t size() const { return side_.size(); }
  /// Of a side that was added.
  std::uint32_t number(std::uint32_t side) const { return number_[side]; }
  /// Of each side of the scene; kNone of those that were not added.
  std::span<const std::uint32_t> numbers() const { return number_; }
  /// False for sides that earlier frames alone showed.
  bool shown(std::size_t number) const { return shown_[number] != 0; }
  std::uint32_t side(std::size_t number) const { return side_[number]; }
  const scene::Facet& facet(std::size_t number) const { return scene_.facets().facet[side_[number] / 2]; }
  float sun_cosine(std::size_t number) const { return sun_cosine_[number]; }
  /// Which part of the side the sun reaches; 0 where it faces away.
  float sun_share(std::size_t number) const { return sun_share_[number]; }

  /// What the side sees: sources as LightSources has them, and their shares.
  struct Light {
    std::span<const std::uint32_t> source;
    std::span<const float> share;
  };
  Light light(std::size_t number) const {
    const std::size_t from = first_[number], size = first_[number + 1] - from;
    return {std::span(source_).subspan(from, size), std::span(share_).subspan(from, size)};
  }

 private:
  std::vector<std::uint32_t> unknown(const VisibleParts& parts);
  /// The sun on the sides from number `first` on.
  void set_sun(std::size_t first);
  /// The views of sides: appends to `first`, `source` and `share`.
  void trace(std::span<const std::uint32_t> of, std::uint64_t seed, std::vector<std::size_t>& first,
             std::vector<std::uint32_t>& source, std::vector<float>& share) const;

  const RenderScene& scene_;
  const Patches& patches_;
  Options options_;
  std::vector<std::uint32_t> number_, side_;
  std::vector<std::uint8_t> shown_;  ///< by number
  std::vector<float> sun_cosine_, sun_share_;
  std::vector<std::size_t> first_{0};
  std::vector<std::uint32_t> source_;
  std::vector<float> share_;
};

}  // namespace radiometry::render
