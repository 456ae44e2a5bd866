// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "octree/index_file/index_file.h"

namespace alidade::tools {

/// What `alidade info --json` prints about an index file beside the facts of its points. `verified`: its
/// checksums were compared.
nlohmann::ordered_json index_json(const IndexFile& index, bool verified);
/// The facts of index_json() as lines for people.
std::vector<std::string> index_lines(const IndexFile& index, bool verified);

}  // namespace alidade::tools
