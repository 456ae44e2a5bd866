// SPDX-License-Identifier: MIT
#include "octree/cloud/cloud_reader.h"

namespace alidade {

std::unique_ptr<CloudReader> open_pcd(InputFile file) {
  throw Error({.file = file.name(), .problem = "not read yet"});
}

}  // namespace alidade
