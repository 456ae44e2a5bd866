// SPDX-License-Identifier: MIT
#include "tools/database_part.h"

#include <fmt/format.h>

#include "database/sqlite/read_cloud_part.h"

namespace alidade {

CloudPart read_database_part(const std::filesystem::path& name, std::span<const PointFilter> any_of,
                             AttributeSet attributes, const Progress& progress) {
  return read_cloud_part(name.string(), any_of, attributes, progress);
}

std::string part_table(const CloudPart& part) {
  const double share = part.chunk_count > 0 ? 100.0 * static_cast<double>(part.chunks_read) /
                                                  static_cast<double>(part.chunk_count)
                                            : 0.0;
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", part.chunks_read, share);
}

}  // namespace alidade
