// SPDX-License-Identifier: MIT
// Any bytes as a COPC file that is queried without loading it: an Error, or all points of all nodes, each
// once and at its position in the loaded cloud.
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"
#include "octree/copc_tree.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"

namespace alidade {
namespace {

std::vector<PointHit> all_points(const CopcFile& file) {
  // So that nodes are decoded again.
  const CopcCache cache(file, {.byte_count = 1000});
  const double far = std::numeric_limits<double>::infinity();
  const Bounds everything{glm::dvec3(-far), glm::dvec3(far)};
  const PointQuery query{};
  const BoxTarget target(everything, query);
  Nearest neighbors(target, query.k);
  tree_query(CopcTree(cache), target, neighbors);
  return neighbors.in_order();
}

}  // namespace
}  // namespace alidade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    const alidade::CopcFile file(alidade::InputFile(bytes, "input"));
    // Memory for points that a chunk only claims to have is never touched, but the fuzzer counts its
    // allocation.
    if (file.header().point_count > 1'000'000) return 0;
    const std::vector<alidade::PointHit> points = alidade::all_points(file);
    alidade::CloudInputs files;
    files.inputs.push_back(alidade::cloud_in_memory(bytes, "input"));
    const alidade::PointCloud cloud = alidade::read_cloud(files, {.attributes = alidade::AttributeSet()});
    if (cloud.size() != points.size()) std::abort();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].point_id != i || points[i].position != cloud.world(i)) std::abort();
    }
  } catch (const alidade::Error&) {
  }
  return 0;
}
