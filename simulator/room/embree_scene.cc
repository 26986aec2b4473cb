#include "simulator/room/embree_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

// Embree 4 is in Debian 13, Embree 3 in Debian 12.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace raywalk::simulator {
namespace {

// The queries of both: their arguments differ. Embree sets tfar = -inf for an occluded ray.
#if RTC_VERSION_MAJOR >= 4

void find_hit(RTCScene scene, RTCRayHit* ray) { rtcIntersect1(scene, ray); }
void find_occlusion(RTCScene scene, RTCRay* ray) { rtcOccluded1(scene, ray); }

#else

void find_hit(RTCScene scene, RTCRayHit* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, ray);
}

void find_occlusion(RTCScene scene, RTCRay* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
}

#endif

[[noreturn]] void throw_embree_error(RTCDevice device) {
  throw Error(fmt::format("the ray tracer Embree failed (error {}); is there enough memory?",
                          static_cast<int>(rtcGetDeviceError(device))));
}

// Embree owns the buffers; they must be filled before the geometry is committed.
void fill_quads(RTCGeometry geometry, std::span<const Facet> facets, RTCDevice device) {
  const std::size_t corners = 4 * facets.size();
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), corners));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), facets.size()));
  if (vertices == nullptr || indices == nullptr) throw_embree_error(device);
  for (const Facet& facet : facets) {
    for (const Eigen::Vector3d& corner : facet.corners) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(corner[axis]);
    }
  }
  for (unsigned i = 0; i < corners; ++i) indices[i] = i;
}

RTCRay ray_for_embree(const Ray& ray, double distance) {
  RTCRay embree{};
  embree.org_x = static_cast<float>(ray.origin.x());
  embree.org_y = static_cast<float>(ray.origin.y());
  embree.org_z = static_cast<float>(ray.origin.z());
  embree.dir_x = static_cast<float>(ray.direction.x());
  embree.dir_y = static_cast<float>(ray.direction.y());
  embree.dir_z = static_cast<float>(ray.direction.z());
  embree.tfar = static_cast<float>(distance);
  embree.mask = ~0U;
  return embree;
}

}  // namespace

void EmbreeScene::Release::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
void EmbreeScene::Release::operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }

EmbreeScene::EmbreeScene(std::span<const Facet> facets) : device_(rtcNewDevice(nullptr)) {
  if (!device_) throw_embree_error(nullptr);
  for (const Facet& facet : facets) {
    planes_.push_back({facet.normal, facet.normal.dot(facet.corners[0])});
  }
  scene_.reset(rtcNewScene(device_.get()));
  // Robust mode: no ray passes through the shared edge of two facets.
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_QUAD);
  const std::unique_ptr<RTCGeometryTy, decltype(&rtcReleaseGeometry)> owner(geometry,
                                                                            &rtcReleaseGeometry);
  fill_quads(geometry, facets, device_.get());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcCommitScene(scene_.get());
  if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
    throw Error(fmt::format("the ray tracer Embree failed to build the room (error {})",
                            static_cast<int>(error)));
  }
}

// Solves normal . (origin + t direction) = offset for t. If the ray is nearly parallel to the
// plane, this is ill-conditioned and Embree's own distance is used.
double EmbreeScene::distance_to_plane(const Ray& ray, int facet, double embree_distance) const {
  const Plane& plane = planes_[static_cast<std::size_t>(facet)];
  const double exact =
      (plane.offset - plane.normal.dot(ray.origin)) / plane.normal.dot(ray.direction);
  const bool agree = std::abs(exact - embree_distance) <= 1e-3 * embree_distance + 1e-5;
  return agree ? exact : embree_distance;
}

Hit EmbreeScene::intersect(const Ray& ray) const {
  RTCRayHit found{ray_for_embree(ray, std::numeric_limits<double>::infinity()), {}};
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  find_hit(scene_.get(), &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const int facet = static_cast<int>(found.hit.primID);
  const double distance = distance_to_plane(ray, facet, static_cast<double>(found.ray.tfar));
  return {facet, distance, found.hit.u, found.hit.v};
}

bool EmbreeScene::occluded(const Ray& ray, double distance) const {
  RTCRay embree = ray_for_embree(ray, distance);
  find_occlusion(scene_.get(), &embree);
  return embree.tfar < 0.0F;
}

}  // namespace raywalk::simulator
