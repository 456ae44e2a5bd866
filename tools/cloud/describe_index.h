// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "octree/index_file/index_file.h"

namespace alidade {

using Json = nlohmann::ordered_json;

/// What `alidade info --json` tells about an index file beside what its points tell.
Json index_json(const IndexFile& index, bool verified);

/// The same as lines for people.
std::vector<std::string> index_lines(const IndexFile& index, bool verified);

}  // namespace alidade
