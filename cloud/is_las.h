// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/point_cloud.h"

namespace alidade {

/// Whether the fields of a file's points are those of LAS, however they are packed.
inline bool is_las(const CloudFile& file) {
  return file.format == "LAS" || file.format == "LAZ" || file.format == "COPC";
}

}  // namespace alidade
