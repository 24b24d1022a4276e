// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rays that share an end, in packets of 16 that Embree takes as they are: a pencil leaves one point, as the rays of a
// camera do; a beam goes in one direction, as shadow rays to the sun do. Both are in single precision about the middle
// of the scene, without the checks and the distances in double precision of rays.h: for frames of a million rays. The
// same triangles are met as there.

#include <array>
#include <cstdint>
#include <span>

#include "radiometry/scene/rays.h"

namespace radiometry::scene {

inline constexpr std::size_t kPencilRays = 16;

/// Directions of any length above 0, finite. The first `count` are rays.
struct PencilDirections {
  alignas(64) std::array<float, kPencilRays> x{}, y{}, z{};
  std::size_t count = 0;
};

struct PencilHits {
  alignas(64) std::array<std::uint32_t, kPencilRays> triangle{};  ///< kNone where the ray leaves the scene
  alignas(64) std::array<float, kPencilRays> length{};            ///< in lengths of the direction
  std::uint32_t back = 0;  ///< bit i: ray i meets the side that the normal does not point to
};

class Pencil {
 public:
  /// `rays` has to outlive the pencil. Throws mtf::UsageError for an origin that is not finite or more than 1e12 m from
  /// the scene.
  Pencil(const Rays& rays, const Point& origin);
  /// The first triangles that the rays meet. From any number of threads at once.
  void trace(const PencilDirections& directions, PencilHits& hits) const;

 private:
  const Rays& rays_;
  std::array<float, 3> origin_;
};

class Beam {
 public:
  /// `direction`: of any length above 0. Throws mtf::UsageError for another one.
  Beam(const Rays& rays, const Vector& direction);
  /// Takes at most 16 points, finite and near the scene. Bit i of the result is set where the ray from point i is
  /// blocked.
  std::uint32_t blocked(std::span<const Point> from) const;
  /// How far above a surface its rays have to start.
  double lift_m() const;
  const Vector& direction() const { return direction_; }

 private:
  const Rays& rays_;
  Vector direction_;
};

/// The distance to the plane of a triangle along a direction of any length, in that length; double precision.
double distance_to(const Facets& facets, std::uint32_t triangle, const Point& origin, const Vector& direction);

}  // namespace radiometry::scene
