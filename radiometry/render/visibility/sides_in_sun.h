// SPDX-License-Identifier: Apache-2.0
#pragma once

// The visible sides that are in the sun as a whole, or in the shadow as a whole, so that no shadow ray need ask.
//
// Seen along the direction of the sun the scene is a plane picture. Over the part of a side that a triangle covers
// there, the triangle is below the plane of the side and takes no light, or above it, or it crosses the plane. A shadow
// has its outlines where surfaces end as the sun sees them: at edges that one triangle has, or that two have which lie
// on the same side of it in the picture, as one of them faces the sun and the other does not. So a side on which no
// triangle crosses the plane and no outline above it falls is in the sun as a whole where nothing is above it, and in
// the shadow as a whole where something is.
//
// All of this is asked in double precision of the triangles whose boxes in the picture meet that of the side, which a
// tree finds. What lies within the lift of shadow rays above the plane is taken to cross it.

#include "radiometry/render/visible_sides.h"

namespace radiometry::render {

enum class InSun : std::uint8_t { partly, wholly, nowhere };  ///< partly: or it is not known

class SidesInSun {
 public:
  /// `lift_m`: as scene::Beam has it. `facets` outlives it.
  SidesInSun(const scene::Facets& facets, const Vector& to_sun, double lift_m, int threads);
  /// Works out the sides that were added to `sides` since it was last called.
  void add(const VisibleSides& sides, int threads);
  /// Of a side by its number in VisibleSides. Sides that face away are nowhere in the sun.
  InSun of(std::size_t number) const { return known_[number]; }
  const Vector& to_sun() const { return to_sun_; }
  /// Of a side that faces the sun.
  InSun find(scene::Side side) const;

 private:
  /// In the picture, and above the plane of the side in question.
  struct Corner {
    double x, y, height_m;
  };
  struct Box {
    double left, right, low, high;
    void take(const Corner& p);
    void take(const Box& other);
    bool meets(const Box& other) const {
      return left <= other.right && other.left <= right && low <= other.high && other.low <= high;
    }
  };
  /// A triangle of a side: its edges as they bound it in the picture.
  struct Target;
  Corner corner(std::uint32_t vertex) const { return {place_[vertex][0], place_[vertex][1], 0.0}; }
  void find_outlines();
  void build_tree(int threads);
  InSun find(const Target& target, std::size_t node, std::size_t first, std::size_t last) const;
  InSun under(const Target& target, std::uint32_t triangle) const;

  const scene::Facets* facets_;
  Vector to_sun_;
  double lift_m_;
  std::vector<std::array<double, 2>> place_;  ///< of each vertex, in the picture
  std::vector<std::uint8_t> outline_;         ///< of each triangle: bit k, the edge from corner k to the next is one
  std::vector<std::uint32_t> order_;          ///< of triangles, as the leaves of the tree have them
  std::vector<Box> box_;                      ///< of nodes: the halves of node k are 2 k + 1 and 2 k + 2
  std::vector<InSun> known_{};                ///< by number
};

}  // namespace radiometry::render
