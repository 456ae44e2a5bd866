// SPDX-License-Identifier: MIT
#pragma once

#include <embree3/rtcore.h>

#include <limits>
#include <map>
#include <memory>

#include "tests/bench/bench_site.h"

namespace alidade::bench {

/// A bench site as Embree spheres, relative to the cloud's corner since Embree computes in float.
class EmbreeSpheres {
 public:
  explicit EmbreeSpheres(const BenchSite& site)
      : origin_(site.octree.bounds().min), device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), site.cloud.size()));
    for (std::size_t i = 0; i < site.cloud.size(); ++i) {
      // In the octree's order, which is Embree's best case (random order costs it up to 8 %).
      const glm::dvec3 p = site.cloud.world(site.octree.view().ids[i]) - origin_;
      for (int axis = 0; axis < 3; ++axis) vertices[4 * i + axis] = static_cast<float>(p[axis]);
      vertices[4 * i + 3] = static_cast<float>(site.radius);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  EmbreeSpheres(const EmbreeSpheres&) = delete;
  EmbreeSpheres& operator=(const EmbreeSpheres&) = delete;
  ~EmbreeSpheres() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  std::uint64_t closest(const Ray& ray) const {
    RTCRayHit hit{};
    set(ray, hit.ray);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &hit);
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? 0 : hit.hit.primID;
  }

  std::uint64_t occluded(const Ray& ray) const {
    RTCRay tested{};
    set(ray, tested);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &tested);
    return tested.tfar < 0.0f;
  }

 private:
  void set(const Ray& ray, RTCRay& to) const {
    const glm::vec3 origin(ray.origin - origin_);
    to.org_x = origin.x;
    to.org_y = origin.y;
    to.org_z = origin.z;
    to.dir_x = static_cast<float>(ray.direction.x);
    to.dir_y = static_cast<float>(ray.direction.y);
    to.dir_z = static_cast<float>(ray.direction.z);
    to.tnear = 1e-4f;
    to.tfar = std::numeric_limits<float>::infinity();
    to.mask = 0xffffffffu;
  }

  glm::dvec3 origin_;
  RTCDevice device_;
  RTCScene scene_;
};

/// Made at the first call for a site, then kept.
inline const EmbreeSpheres& embree_spheres(const BenchSite& site) {
  static std::map<std::size_t, std::unique_ptr<EmbreeSpheres>> scenes;
  std::unique_ptr<EmbreeSpheres>& scene = scenes[site.cloud.size()];
  if (!scene) scene = std::make_unique<EmbreeSpheres>(site);
  return *scene;
}

}  // namespace alidade::bench
