// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/beam.h"

#include <array>

#include "mtf/error.h"
#include "radiometry/scene/tracing/embree_scene.h"

namespace radiometry::scene {

static_assert(kBeamRays == kPacket);

Beam::Beam(const Rays& rays, const Vector& direction) : rays_(rays), direction_(direction) {
  const double norm = length(direction);
  if (!(norm > 1e-150 && norm < 1e150))
    throw mtf::UsageError("rays go in a direction without a length from 1e-150 to 1e150.");
  direction_ = (1.0 / norm) * direction;
}

std::uint32_t Beam::blocked(std::span<const Point> from) const {
  std::array<SingleRay, kPacket> packet;
  for (std::size_t i = 0; i < from.size(); ++i) packet[i] = rays_.embree().single(from[i], direction_);
  return rays_.embree().blocked(std::span<const SingleRay>(packet).first(from.size()));
}

double Beam::lift_m() const { return rays_.embree().lift_m(); }

}  // namespace radiometry::scene
