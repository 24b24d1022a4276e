// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/tracing/embree_scene.h"

#include <cmath>
#include <limits>
#include <string>

#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/work/usable_memory.h"

namespace radiometry::scene {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

[[noreturn]] void fail(RTCError error) {
  throw mtf::RuntimeError(error == RTC_ERROR_OUT_OF_MEMORY
                              ? "Embree: there is not enough memory for the triangles of the scene: use a coarser mesh."
                              : "Embree: error " + std::to_string(error) + " while the scene was built.");
}

/// A buffer of Embree's own with the elements that `item(i)` gives.
template <class T, class Item>
void fill(RTCDevice device, RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count, Item item) {
  auto* out = static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count));
  if (out == nullptr) fail(rtcGetDeviceError(device));
  for (std::size_t i = 0; i < count; ++i) out[i] = item(i);
}

template <class Packet>
void set_ray(Packet& packet, std::size_t lane, const SingleRay& ray) {
  packet.org_x[lane] = ray.origin[0], packet.org_y[lane] = ray.origin[1], packet.org_z[lane] = ray.origin[2];
  packet.dir_x[lane] = ray.direction[0], packet.dir_y[lane] = ray.direction[1], packet.dir_z[lane] = ray.direction[2];
  packet.tnear[lane] = 0.0F, packet.time[lane] = 0.0F, packet.tfar[lane] = kInfinity;
  packet.mask[lane] = ~0U, packet.id[lane] = 0U, packet.flags[lane] = 0U;
}

/// Lanes without a ray of their own carry the first one: Embree's assertions look at masked lanes too.
void set_rays(RTCRay16& packet, int* valid, std::span<const SingleRay> rays) {
  for (std::size_t lane = 0; lane < kPacket; ++lane) {
    set_ray(packet, lane, rays[lane < rays.size() ? lane : 0]);
    valid[lane] = lane < rays.size() ? -1 : 0;
  }
}

RTCRay single_ray(const SingleRay& ray) {
  RTCRay out{};
  out.org_x = ray.origin[0], out.org_y = ray.origin[1], out.org_z = ray.origin[2];
  out.dir_x = ray.direction[0], out.dir_y = ray.direction[1], out.dir_z = ray.direction[2];
  out.tfar = kInfinity;
  out.mask = ~0U;
  return out;
}

std::array<float, 3> rounded(const Vector& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

}  // namespace

EmbreeScene::EmbreeScene(const Facets& facets)
    : middle_(facets.middle), lift_m_(0x1p-21 * facets.half_extent_m), device_(rtcNewDevice(nullptr)) {
  if (!device_) {
    const mtf::UsableMemory memory = mtf::usable_memory();
    throw mtf::RuntimeError(std::string("Embree, which traces the rays, cannot begin; ") + memory.whose + " " +
                            mtf::format_double(std::round(memory.bytes / 1048576.0)) +
                            " MiB: where that is little, raise the limit");
  }
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  RTCGeometryTy* const geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);  // the scene holds it
  fill<std::array<float, 3>>(device_.get(), geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, facets.vertices.size(),
                             [&](std::size_t i) { return rounded(facets.vertices[i] - middle_); });
  fill<std::array<std::uint32_t, 3>>(device_.get(), geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                     facets.triangles.size(), [&](std::size_t i) { return facets.triangles[i]; });
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene_.get());
  if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) fail(error);
}

SingleRay EmbreeScene::single(const Point& origin, const Vector& direction) const {
  return {rounded(origin - middle_), rounded(direction)};
}

EmbreeScene::FirstTriangle EmbreeScene::first_triangle(const SingleRay& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit hit{};
  hit.ray = single_ray(ray);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_.get(), &context, &hit);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {kNone, false};
  const float towards = hit.hit.Ng_x * hit.ray.dir_x + hit.hit.Ng_y * hit.ray.dir_y + hit.hit.Ng_z * hit.ray.dir_z;
  return {hit.hit.primID, towards > 0.0F};
}

bool EmbreeScene::blocked(const SingleRay& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay out = single_ray(ray);
  rtcOccluded1(scene_.get(), &context, &out);
  return out.tfar < 0.0F;
}

void EmbreeScene::first_triangles(std::span<const SingleRay> rays, std::span<std::uint32_t> triangles) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit16 packet;
  alignas(64) int valid[kPacket];
  set_rays(packet.ray, valid, rays);
  for (std::size_t lane = 0; lane < kPacket; ++lane) packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect16(valid, scene_.get(), &context, &packet);
  for (std::size_t lane = 0; lane < rays.size(); ++lane)
    triangles[lane] = packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID ? kNone : packet.hit.primID[lane];
}

std::uint32_t EmbreeScene::blocked(std::span<const SingleRay> rays) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRay16 packet;
  alignas(64) int valid[kPacket];
  set_rays(packet, valid, rays);
  rtcOccluded16(valid, scene_.get(), &context, &packet);
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < rays.size(); ++lane) bits |= packet.tfar[lane] < 0.0F ? 1U << lane : 0U;
  return bits;
}

}  // namespace radiometry::scene
