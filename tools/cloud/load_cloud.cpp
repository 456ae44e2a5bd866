// SPDX-License-Identifier: MIT
#include "tools/cloud/load_cloud.h"

#include <fmt/format.h>

#include "base/error.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade::tools {

IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options) {
  Console console(request.verbosity);
  return jobs::load_cloud(request.files, request.partial, std::move(options), console);
}

std::string part_table(const database::CloudPart& part) {
  if (part.chunk_count == 0) return fmt::format("{:<22}{:>16}\n", "points read", part.ids.size());
  const double share = 100.0 * static_cast<double>(part.chunks_read) / static_cast<double>(part.chunk_count);
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", part.chunks_read, share);
}

}  // namespace alidade::tools
