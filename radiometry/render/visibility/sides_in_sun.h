// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the sun reaches the visible sides, in place of shadow rays.
//
// In the picture that the sun sees (SunPicture) a place on a side is in the shadow if triangles cover it that are
// above the plane of the side there. How many do is a winding number (Edelsbrunner, "Geometry and Topology for Mesh
// Generation", 2001, section 1.1): once it is known at one place c of the side, it is known at every other place p from
// the lines that the way from c to p crosses. These lines are the outlines of what is above the plane, and where
// triangles go through the plane. They are found in double precision from the triangles whose boxes meet that of the
// side, when the side is first seen, and kept in single precision from c: they are off by some 1e-7 of the distance.
//
// Most sides have no such line: they are in the sun, or in the shadow, as a whole. The others keep theirs, a few dozen
// as a rule; a place then takes some tens of nanoseconds, where a ray takes some hundreds. What lies within the lift of
// shadow rays above the plane throws no shadow on it.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "radiometry/render/visible_sides.h"
#include "radiometry/scene/facets.h"

namespace radiometry::render {

// The scene as the sun sees it: along its direction everything is a plane picture, in which a triangle covers what is
// behind it. Shadows end at the outlines of the picture: at edges that one triangle has alone, or that several have of
// which not exactly one lies on either side, as where a surface turns away from the sun.

using scene::Point, scene::Vector;

class SunPicture {
 public:
  /// Metres across the direction to the sun, from the middle of the scene.
  using Place = std::array<double, 2>;
  struct Box {
    Place low, high;
    static Box none();
    void take(const Place& p);
    void take(const Box& other);
    bool meets(const Box& other) const {
      return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1];
    }
  };

  /// `to_sun`: of length 1. `facets` outlives it.
  SunPicture(const scene::Facets& facets, const Vector& to_sun, int threads);

  const Vector& to_sun() const { return to_sun_; }
  /// Of the picture; with the direction to the sun they are a right-handed frame.
  const std::array<Vector, 2>& axes() const { return axes_; }
  const Place& place(std::uint32_t vertex) const { return place_[vertex]; }
  /// Whether the edge from corner `k` of a triangle to the next is an outline.
  bool outline(std::uint32_t triangle, std::size_t k) const { return (outline_[triangle] >> k & 1U) != 0U; }
  /// Whether a triangle runs counter-clockwise, as its front faces the sun.
  bool faces(std::uint32_t triangle) const { return (outline_[triangle] & kFaces) != 0U; }
  /// Gives `take` each triangle whose box meets `box`, and stops where it returns false.
  template <class Take>
  void visit(const Box& box, const Take& take) const {
    visit(box, take, 0, 0, order_.size());
  }

 private:
  static constexpr std::size_t kLeaf = 8;  // triangles
  static constexpr std::uint8_t kFaces = 8U;

  void find_outlines();
  void build_tree(int threads);
  template <class Take>
  bool visit(const Box& box, const Take& take, std::size_t node, std::size_t first, std::size_t last) const {
    if (!box_[node].meets(box)) return true;
    if (last - first > kLeaf) {
      const std::size_t middle = first + (last - first) / 2;
      return visit(box, take, 2 * node + 1, first, middle) && visit(box, take, 2 * node + 2, middle, last);
    }
    return std::all_of(order_.begin() + static_cast<std::ptrdiff_t>(first),
                       order_.begin() + static_cast<std::ptrdiff_t>(last), take);
  }

  const scene::Facets* facets_;
  Vector to_sun_;
  std::array<Vector, 2> axes_{};
  std::vector<Place> place_;           ///< of each vertex
  std::vector<std::uint8_t> outline_;  ///< of each triangle: bit k, and kFaces
  std::vector<std::uint32_t> order_;   ///< of triangles, as the leaves of the tree have them
  std::vector<Box> box_;               ///< of nodes: the halves of node k are 2 k + 1 and 2 k + 2
};

/// `unknown`: too many lines, too thin for them, or no place c that is clear of them; rays tell.
enum class InSun : std::uint8_t { partly, wholly, nowhere, unknown };

/// A place on a side that is partly in the sun.
struct SunQuestion {
  std::uint32_t number = 0;  ///< of the side, in VisibleSides
  SunPicture::Place place{};
};

class SidesInSun {
 public:
  /// `lift_m`: as scene::Beam has it. `facets` outlives it.
  SidesInSun(const scene::Facets& facets, const Vector& to_sun, double lift_m, int threads);
  /// Works out the sides that were added to `sides` since it was last called.
  void add(const VisibleSides& sides, int threads);
  /// Of a side by its number in VisibleSides. Sides that face away are nowhere in the sun.
  InSun of(std::size_t number) const { return known_[number].in_sun; }
  /// Whether the sun reaches these places, which are on sides that it partly reaches.
  void reaches(std::span<const SunQuestion> places, std::span<std::uint8_t> lit) const;
  const SunPicture& picture() const { return *picture_; }

  /// Lines in single precision from a place c of a side; what they enclose is on their left.
  struct Lines {
    InSun in_sun = InSun::unknown;
    SunPicture::Place c{};
    int covers = 0;  ///< triangles that are over c
    /// Blocks of kBlock lines: x of their beginnings, y of them, x and y of their ends. Empty lines fill the last.
    std::vector<float> ends{};
    static constexpr std::size_t kBlock = 16;
  };
  /// Of a side that faces the sun.
  Lines find(scene::Side side) const;

 private:
  struct Known {
    InSun in_sun = InSun::nowhere;
    std::int32_t covers = 0;
    SunPicture::Place c{};
    std::size_t first = 0, blocks = 0;  ///< in ends_
  };

  const scene::Facets* facets_;
  double lift_m_;
  std::shared_ptr<const SunPicture> picture_;  ///< copies share it
  std::vector<Known> known_{};                 ///< by number
  std::vector<float> ends_{};
};

/// Which parts of samples the sun reaches: fills `lit` of all parts and runs, and returns the number of shadow rays.
/// Sides that are in the sun as a whole, or in the shadow, take no work; runs on sides in part are divided. Where a
/// side is `unknown`, each part has a ray. With a null `in_sun` every part that faces the sun has. The sides of the
/// parts are among `sides`.
std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads);

}  // namespace radiometry::render
