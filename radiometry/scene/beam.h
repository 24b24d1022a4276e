// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rays in one direction, as shadow rays to the sun are, in packets of 16 that Embree takes as they are: in single
// precision about the middle of the scene, without the checks and the distances in double precision of rays.h, for
// many rays at a time. The same triangles are met as there.

#include <cstdint>
#include <span>

#include "radiometry/scene/rays.h"

namespace radiometry::scene {

inline constexpr std::size_t kBeamRays = 16;

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

}  // namespace radiometry::scene
