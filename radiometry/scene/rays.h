// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rays against the facets of a scene, by Embree (Wald, Woop, Benthin, Johnson and Ernst, "Embree: a kernel framework
// for efficient CPU ray tracing", ACM Trans. Graph. 33, 2014) with its robust traversal: no ray slips between triangles
// that share an edge. Traversal is in single precision about the middle of the scene; the distance of a hit is then
// computed again in double precision from the plane of the triangle.
//
// Debian's Embree has its assertions on: a ray or a vertex that is not finite, or beyond 1.8e18, would end the process.
// Facets hold none (facets.h), and rays are checked here: such a ray is a mtf::UsageError that names it.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "radiometry/scene/facets.h"

namespace radiometry::scene {

/// Of an origin from the middle of the scene: its single-precision value is finite, and so are Embree's products.
inline constexpr double kFarthestOrigin_m = 1e12;

struct Ray {
  Point origin;      ///< in coordinates of the scene
  Vector direction;  ///< of any length above 0
};

struct Hit {
  std::uint32_t facet = kNone;
  bool back = false;        ///< the ray meets the side that the normal does not point to
  double distance_m = 0.0;  ///< from the origin
};
constexpr bool hits(const Hit& hit) { return hit.facet != kNone; }

class EmbreeScene;  // embree_scene.h

/// Facets with the tree of boxes that rays are traced through. All members are const and may be called from any number
/// of threads; a moved-from object may only be destroyed or assigned to.
class Rays {
 public:
  /// Takes about 0.3 us a triangle.
  explicit Rays(Facets facets);
  Rays(Rays&&) noexcept;
  Rays& operator=(Rays&&) noexcept;
  ~Rays();

  const Facets& facets() const { return facets_; }

  /// The first facet that the ray meets.
  Hit first_hit(const Ray& ray) const;
  /// The same for many rays, in packets of 16: several times faster when neighbours in the list are neighbours in
  /// space, as the rays of a camera are. `hits` is as long as `rays`. `threads` 0: all cores; the hits are the same.
  void first_hits(std::span<const Ray> rays, std::span<Hit> hits, int threads = 0) const;

  const EmbreeScene& embree() const { return *embree_; }  ///< for the sources of this library

 private:
  Facets facets_;
  std::unique_ptr<EmbreeScene> embree_;
};

inline constexpr std::size_t kBeamRays = 16;

/// Rays in one direction, as shadow rays to the sun are, in packets of 16 that Embree takes as they are: in single
/// precision about the middle of the scene, without the checks and the distances in double precision of Rays, for many
/// rays at a time. The same triangles are met as there.
class Beam {
 public:
  /// `direction`: of any length above 0. Throws mtf::UsageError for another one.
  Beam(const Rays& rays, const Vector& direction);
  /// Takes at most 16 points, finite and near the scene. Bit i of the result: the ray from point i is blocked.
  std::uint32_t blocked(std::span<const Point> from) const;
  /// How far above a surface its rays have to start.
  double lift_m() const;
  const Vector& direction() const { return direction_; }

 private:
  const Rays& rays_;
  Vector direction_;
};

/// Walls of closed shells: the facet on the other side of the wall, for conduction through it.
struct OppositeFacets {
  std::vector<std::uint32_t> opposite;  ///< of each of the facets asked for, or kNone
  std::vector<double> distance_m;       ///< to it; 0 where there is none
  std::size_t unpaired = 0;             ///< facets without one, those of open shells included
};

/// A ray from the centre of a facet goes inwards, against the normal; where it meets the back of a facet of a closed
/// shell within the thickness, the two are opposite. The relation need not be mutual: the faces of a wedge, or facets
/// of different size, are opposite to whichever facet their centre projects on. Throws mtf::UsageError for a thickness
/// that is not above 0.
OppositeFacets opposite_facets(const Rays& rays, std::span<const std::uint32_t> facets, double thickness_m,
                               int threads = 0);

}  // namespace radiometry::scene
