// SPDX-License-Identifier: MIT
#include "tools/cloud/describe_copc.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "cloud/copc/copc_file.h"

namespace alidade {

std::string copc_text(const std::filesystem::path& file) {
  try {
    const CopcFile copc{InputFile(file)};
    const auto& nodes = copc.hierarchy().nodes;
    const auto chunks =
        std::ranges::count_if(nodes, [](const CopcNode& node) { return node.chunk.point_count > 0; });
    return fmt::format("octree of {} levels, {} nodes with points, spacing {} in the root",
                       copc.hierarchy().levels(), chunks, copc.info().spacing);
  } catch (const Error& error) {
    return fmt::format("octree that cannot be used: {}", error.parts().problem);
  }
}

}  // namespace alidade
