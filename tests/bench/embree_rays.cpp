// SPDX-License-Identifier: MIT
// Embree's side of the ray benchmarks: spheres of the query's radius around the same points, the same rays.
#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/bench/bench_site.h"
#include "tests/bench/embree_scene.h"
#include "tests/bench/ray_bench.h"
#include "tests/bench/timing.h"

namespace alidade::bench {
namespace {

using test::EmbreeSpheres;

// A ray that leaves a sphere must not meet it again.
constexpr float k_begin = 1e-4f;

/// Answers whether `rays` of the site's hit the same spheres by Embree's account as by ours; throws
/// otherwise. Not more than a few rays in a thousand pass a rim so closely that float and double see
/// different spheres.
void compare(const BenchSite& site, const EmbreeSpheres& spheres) {
  const std::vector<Ray>& rays = site.rays("P");
  constexpr std::size_t k_samples = 2000;
  std::size_t different = 0;
  for (std::size_t i = 0; i < k_samples; ++i) {
    const Ray& ray = rays[i * rays.size() / k_samples];
    const std::optional<Hit> ours = closest(site.octree, ray, site.query());
    const RTCRayHit theirs = spheres.closest(ray, k_begin);
    const bool hit = theirs.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    different += hit != ours.has_value() || (ours && std::abs(ours->entry - theirs.ray.tfar) > 1e-3);
  }
  if (different > k_samples / 200) {
    throw std::runtime_error("Embree and the octree differ on " + std::to_string(different) + " of " +
                             std::to_string(k_samples) + " rays");
  }
}

const EmbreeSpheres& embree_spheres(const BenchSite& site) {
  static std::map<std::size_t, std::unique_ptr<EmbreeSpheres>> scenes;
  std::unique_ptr<EmbreeSpheres>& scene = scenes[site.cloud.size()];
  if (!scene) {
    scene = embree_scene(site);
    compare(site, *scene);
  }
  return *scene;
}

/// Flushes denormal floats to zero while it lives, as Embree's manual recommends.
class FlushDenormals {
 public:
#if defined(__x86_64__)
  FlushDenormals() : before_(__builtin_ia32_stmxcsr()) {
    __builtin_ia32_ldmxcsr(before_ | 0x8040u);
  }
  ~FlushDenormals() {
    __builtin_ia32_ldmxcsr(before_);
  }

 private:
  unsigned before_;
#endif
};

struct Mode {
  const char* name;
  int packet;  ///< rays per call
};
constexpr Mode k_modes[] = {{"single", 1}, {"packet8", 8}, {"packet16", 16}, {"stream", 4096}};

/// The context of a set of rays. Rays of a camera and of a sun are declared coherent, as programs do.
RTCIntersectContext context_for(const std::string& set) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const bool coherent = set == "P" || set == "A_sun";
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

/// Rays as programs hold them for Embree, ready to be copied: Embree writes its answers over them.
std::vector<RTCRayHit> prepared(const EmbreeSpheres& spheres, const std::vector<Ray>& rays) {
  std::vector<RTCRayHit> all;
  all.reserve(rays.size());
  for (const Ray& ray : rays) all.push_back(spheres.prepare(ray, k_begin));
  return all;
}

void intersect(const int* valid, RTCScene scene, RTCIntersectContext& context, RTCRayHit8& packet) {
  rtcIntersect8(valid, scene, &context, &packet);
}
void intersect(const int* valid, RTCScene scene, RTCIntersectContext& context, RTCRayHit16& packet) {
  rtcIntersect16(valid, scene, &context, &packet);
}
void occlude(const int* valid, RTCScene scene, RTCIntersectContext& context, RTCRayHit8& packet) {
  rtcOccluded8(valid, scene, &context, &packet.ray);
}
void occlude(const int* valid, RTCScene scene, RTCIntersectContext& context, RTCRayHit16& packet) {
  rtcOccluded16(valid, scene, &context, &packet.ray);
}

template <class Packet>
constexpr std::size_t k_lanes = std::extent_v<decltype(Packet().hit.primID)>;

/// Rays side by side.
template <class Packet>
void gather(std::span<const RTCRayHit> rays, Packet& packet, std::int32_t (&valid)[k_lanes<Packet>]) {
  for (std::size_t lane = 0; lane < k_lanes<Packet>; ++lane) {
    valid[lane] = lane < rays.size() ? -1 : 0;
    const RTCRay& ray = rays[std::min(lane, rays.size() - 1)].ray;
    packet.ray.org_x[lane] = ray.org_x;
    packet.ray.org_y[lane] = ray.org_y;
    packet.ray.org_z[lane] = ray.org_z;
    packet.ray.dir_x[lane] = ray.dir_x;
    packet.ray.dir_y[lane] = ray.dir_y;
    packet.ray.dir_z[lane] = ray.dir_z;
    packet.ray.tnear[lane] = ray.tnear;
    packet.ray.tfar[lane] = ray.tfar;
    packet.ray.time[lane] = 0.0f;
    packet.ray.mask[lane] = ray.mask;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

/// Calls trace(packet, valid) for all rays, gathered into packets, and then read(packet, lane) for each.
template <class Packet, class Trace, class Read>
void in_packets(std::span<const RTCRayHit> rays, const Trace& trace, const Read& read) {
  alignas(64) Packet packet;
  alignas(64) std::int32_t valid[k_lanes<Packet>];
  for (std::size_t begin = 0; begin < rays.size(); begin += k_lanes<Packet>) {
    const std::size_t size = std::min(k_lanes<Packet>, rays.size() - begin);
    gather(rays.subspan(begin, size), packet, valid);
    trace(packet, valid);
    for (std::size_t lane = 0; lane < size; ++lane) read(packet, lane);
  }
}

/// How many of these rays hit; every answer is read. Works in `stream`.
std::size_t closest_hits(RTCScene scene, std::span<const RTCRayHit> rays, const Mode& mode,
                         RTCIntersectContext context, std::vector<RTCRayHit>& stream) {
  std::size_t hits = 0;
  std::uint64_t ids = 0;
  const auto count = [&](unsigned geometry, unsigned id) {
    if (geometry != RTC_INVALID_GEOMETRY_ID) ids += id, ++hits;
  };
  if (mode.packet == 1) {
    for (const RTCRayHit& ray : rays) {
      RTCRayHit hit = ray;
      rtcIntersect1(scene, &context, &hit);
      count(hit.hit.geomID, hit.hit.primID);
    }
  } else if (mode.packet <= 16) {
    const auto trace = [&](auto& packet, const auto& valid) { intersect(valid, scene, context, packet); };
    const auto read = [&](const auto& packet, std::size_t lane) {
      count(packet.hit.geomID[lane], packet.hit.primID[lane]);
    };
    mode.packet == 8 ? in_packets<RTCRayHit8>(rays, trace, read) : in_packets<RTCRayHit16>(rays, trace, read);
  } else {
    stream.assign(rays.begin(), rays.end());
    rtcIntersect1M(scene, &context, stream.data(), static_cast<unsigned>(stream.size()), sizeof(RTCRayHit));
    for (const RTCRayHit& hit : stream) count(hit.hit.geomID, hit.hit.primID);
  }
  benchmark::DoNotOptimize(ids);
  return hits;
}

std::size_t occluded_hits(RTCScene scene, std::span<const RTCRayHit> rays, const Mode& mode,
                          RTCIntersectContext context, std::vector<RTCRayHit>& stream) {
  std::size_t hits = 0;
  if (mode.packet == 1) {
    for (const RTCRayHit& ray : rays) {
      RTCRay traced = ray.ray;
      rtcOccluded1(scene, &context, &traced);
      hits += traced.tfar < 0.0f;
    }
  } else if (mode.packet <= 16) {
    const auto trace = [&](auto& packet, const auto& valid) { occlude(valid, scene, context, packet); };
    const auto read = [&](const auto& packet, std::size_t lane) { hits += packet.ray.tfar[lane] < 0.0f; };
    mode.packet == 8 ? in_packets<RTCRayHit8>(rays, trace, read) : in_packets<RTCRayHit16>(rays, trace, read);
  } else {
    stream.assign(rays.begin(), rays.end());
    rtcOccluded1M(scene, &context, &stream.data()->ray, static_cast<unsigned>(stream.size()),
                  sizeof(RTCRayHit));
    for (const RTCRayHit& traced : stream) hits += traced.ray.tfar < 0.0f;
  }
  return hits;
}

using TraceRays = std::size_t (*)(RTCScene, std::span<const RTCRayHit>, const Mode&, RTCIntersectContext,
                                  std::vector<RTCRayHit>&);

void time_embree(benchmark::State& state, std::int64_t points, const std::string& set, const Mode& mode,
                 TraceRays trace, int threads) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const EmbreeSpheres& spheres = embree_spheres(site);
  const std::vector<RTCRayHit> rays = prepared(spheres, site.rays(set));
  const std::size_t block = mode.packet <= 16 ? k_rays_per_task : static_cast<std::size_t>(mode.packet);
  const RTCIntersectContext context = context_for(set);
  const std::size_t blocks = (rays.size() + block - 1) / block;
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = on_threads(threads, [&] {
      return tbb::parallel_reduce(
          tbb::blocked_range<std::size_t>(0, blocks), std::size_t{0},
          [&](const auto& range, std::size_t sum) {
            const FlushDenormals flush;
            std::vector<RTCRayHit> room;
            for (std::size_t b = range.begin(); b != range.end(); ++b)
              sum += trace(spheres.scene(),
                           std::span(rays).subspan(b * block, std::min(block, rays.size() - b * block)), mode,
                           context, room);
            return sum;
          },
          std::plus<>());
    });
  }
  report_rays(state, rays.size(), hits);
}

void count_embree(benchmark::State& state, std::int64_t points, const std::string& set, const Mode& mode,
                  TraceRays trace) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const EmbreeSpheres& spheres = embree_spheres(site);
  const std::vector<RTCRayHit> rays = prepared(spheres, counted_rays(site.rays(set), mode.packet > 1));
  std::vector<RTCRayHit> room(rays.size());
  for (auto _ : state) {
    report_instructions(state, rays.size(), [&] {
      benchmark::DoNotOptimize(trace(spheres.scene(), rays, mode, context_for(set), room));
    });
  }
}

}  // namespace

void register_embree_rays() {
  for (const std::int64_t points : k_site_sizes) {
    const std::string count = std::to_string(points);
    const auto add = [&](const std::string& question, const std::string& set, TraceRays trace) {
      for (const Mode& mode : k_modes) {
        for (const int threads : {1, 2}) {
          add_benchmark(threads, {"embree", question, set, with_threads(mode.name, threads), count},
                        time_embree, points, set, mode, trace, threads);
        }
        if (points == k_site_sizes[0])
          add_benchmark(1, {"embree", "instructions", question, set, mode.name, count}, count_embree, points,
                        set, mode, trace);
      }
    };
    for (const char* set : k_closest_sets) add("closest", set, closest_hits);
    for (const char* set : k_occluded_sets) add("occluded", set, occluded_hits);
  }
}

}  // namespace alidade::bench
