// SPDX-License-Identifier: MIT
#include "octree/cloud/cloud_reader.h"

namespace alidade {

std::unique_ptr<CloudReader> open_text(const std::filesystem::path& path) {
  throw Error({.file = path.string(), .problem = "not read yet"});
}

}  // namespace alidade
