// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rays of a frame, in packets of 16 that lie close together: tiles of 4 x 4 samples, one ray each, or the further
// rays of single samples. What a ray meets is kept in the order of packets.

#include <cstdint>
#include <vector>

#include "radiometry/render/camera.h"
#include "radiometry/scene/pencil.h"

namespace radiometry::render {

/// What each ray meets.
struct RayHits {
  std::vector<std::uint32_t> side{};      ///< scene::index(side); kNone where the ray leaves the scene
  std::vector<float> range_m{};           ///< along the ray
  std::vector<float> height_m{};          ///< of what it meets; where it leaves, the sine of its elevation
  std::vector<std::uint8_t> lit{};        ///< the sun reaches it; empty where nobody asked
  std::vector<std::uint32_t> triangle{};  ///< kept where it is asked for, else empty

  std::size_t packets() const { return side.size() / scene::kPencilRays; }
  void resize(std::size_t packets, bool triangles);
};

/// Where in the image the rays of packets go.
class RayPlan {
 public:
  /// One ray through the middle of each sample, tiles of 4 x 4 row by row; those of the last tiles may lie beyond the
  /// image.
  static RayPlan tiles(const Camera& camera);
  /// n x n rays spread evenly over each of these samples; n is 2 or 4.
  static RayPlan further(const Camera& camera, std::vector<std::uint32_t> samples, int n);

  std::size_t packets() const { return packets_; }
  /// Ray `lane` of a packet: its sample, kNone where it has none, and its place in samples from the outer corner.
  struct Place {
    std::uint32_t sample;  ///< y * width + x
    double x, y;
  };
  Place place(std::size_t packet, std::size_t lane) const;

 private:
  std::int64_t width_ = 0, height_ = 0, tiles_ = 0;
  int n_ = 1;
  std::vector<std::uint32_t> samples_;
  std::size_t packets_ = 0;
};

/// Traces packets [first, first + hits.packets()) of the plan. `hits` has its size; the result does not depend on
/// `threads`.
void trace_rays(const scene::Rays& rays, const Camera& camera, const RayPlan& plan, std::size_t first, RayHits& hits,
                int threads);

/// Fills `lit`: shadow rays from what faces the sun; the other sides are dark.
void trace_shadows(const scene::Rays& rays, const Camera& camera, const RayPlan& plan, std::size_t first,
                   const scene::Vector& to_sun, RayHits& hits, int threads);

}  // namespace radiometry::render
