// SPDX-License-Identifier: MIT
#pragma once

#include <embree3/rtcore.h>
#include <sys/mman.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>

#include "base/ray.h"
#include "cloud/point_cloud.h"

namespace alidade::test {

/// A cloud as Embree spheres of one radius. Coordinates are taken relative to `origin`, since Embree computes
/// in float.
class EmbreeSpheres {
 public:
  /// Sphere i is around the point with row order[i], or row i where no order is given. Spheres that are
  /// neighbours in `order` should be neighbours in space: random order costs Embree up to 8 % (Morton order
  /// is its best case).
  EmbreeSpheres(const PointCloud& cloud, double radius, const glm::dvec3& origin = glm::dvec3(0.0),
                std::span<const std::uint32_t> order = {})
      : vertex_count_(cloud.size()),
        origin_(origin),
        vertices_(huge_pages(cloud.size())),
        device_(rtcNewDevice(nullptr)),
        scene_(rtcNewScene(device_)) {
    tbb::parallel_for(std::size_t{0}, cloud.size(), [&](std::size_t i) {
      const glm::dvec3 p = cloud.world(order.empty() ? i : order[i]) - origin_;
      for (int axis = 0; axis < 3; ++axis) vertices_[4 * i + axis] = static_cast<float>(p[axis]);
      vertices_[4 * i + 3] = static_cast<float>(radius);
    });
    rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &allocated_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, vertices_.get(), 0,
                               k_vertex_size, cloud.size());
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

  RTCScene scene() const { return scene_; }
  /// Bytes that Embree has allocated, and the vertices.
  std::size_t memory() const { return allocated_ + vertex_count_ * k_vertex_size; }

  /// The ray as Embree takes it, from t = `begin` (at least its t_min) to its t_max; nothing hit yet.
  RTCRayHit prepare(const Ray& ray, float begin = 0.0f) const {
    RTCRayHit prepared{};
    const glm::vec3 start(ray.origin - origin_), direction(ray.direction);
    RTCRay& to = prepared.ray;
    to.org_x = start.x, to.org_y = start.y, to.org_z = start.z;
    to.dir_x = direction.x, to.dir_y = direction.y, to.dir_z = direction.z;
    to.tnear = std::max(begin, static_cast<float>(ray.t_min));
    to.tfar = static_cast<float>(ray.t_max);
    to.mask = 0xffffffffu;
    prepared.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    return prepared;
  }

  /// The first hit at or after `begin`; geomID is RTC_INVALID_GEOMETRY_ID for a miss.
  RTCRayHit closest(const Ray& ray, float begin = 0.0f) const {
    RTCRayHit hit = prepare(ray, begin);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &hit);
    return hit;
  }

 private:
  struct Free {
    void operator()(float* memory) const { std::free(memory); }
  };
  static constexpr std::size_t k_vertex_size = 4 * sizeof(float);

  /// Memory as Embree takes it for its own nodes; on small pages its reads of vertices would be slower.
  static std::unique_ptr<float[], Free> huge_pages(std::size_t vertex_count) {
    constexpr std::size_t k_page = std::size_t{2} << 20;
    const std::size_t size = (vertex_count * k_vertex_size + k_page) / k_page * k_page;
    void* memory = std::aligned_alloc(k_page, size);
    if (memory == nullptr) throw std::bad_alloc();
    madvise(memory, size, MADV_HUGEPAGE);
    return std::unique_ptr<float[], Free>(static_cast<float*>(memory));
  }

  static bool count_memory(void* allocated, ssize_t bytes, bool) {
    *static_cast<std::atomic<std::size_t>*>(allocated) += static_cast<std::size_t>(bytes);
    return true;
  }

  std::size_t vertex_count_;
  std::atomic<std::size_t> allocated_ = 0;
  glm::dvec3 origin_;
  std::unique_ptr<float[], Free> vertices_;
  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace alidade::test
