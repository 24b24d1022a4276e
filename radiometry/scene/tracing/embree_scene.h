// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles of a scene in Embree. The only header that shows it; embree_scene.cpp checks that a vertex is finite,
// and those who make rays see to it that rays are.

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "radiometry/scene/facets.h"

namespace radiometry::scene {

/// A ray as Embree takes it: in single precision, about the middle of the scene.
struct SingleRay {
  std::array<float, 3> origin{}, direction{};
};

inline constexpr std::size_t kPacket = 16;

class EmbreeScene {
 public:
  explicit EmbreeScene(const Facets& facets);

  SingleRay single(const Point& origin, const Vector& direction) const;

  /// Rays that leave a surface start this far above it. Vertices and origins are rounded to half a unit in the last
  /// place of single precision, 2^-25 of the largest coordinate on each axis; both together are less than 2^-22 of it.
  double lift_m() const { return lift_m_; }

  /// The number of the first triangle, or kNone; whether the ray meets the back of it.
  struct FirstTriangle {
    std::uint32_t number;
    bool back;
  };
  FirstTriangle first_triangle(const SingleRay& ray) const;
  bool blocked(const SingleRay& ray) const;
  /// Up to kPacket rays together.
  void first_triangles(std::span<const SingleRay> rays, std::span<std::uint32_t> triangles) const;
  /// Bit i of the result: ray i, of up to kPacket, is blocked.
  std::uint32_t blocked(std::span<const SingleRay> rays) const;

 private:
  Point middle_;
  double lift_m_;
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
};

}  // namespace radiometry::scene
