// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "octree/cloud/point_cloud.h"
#include "octree/progress.h"

namespace alidade {

enum class PlyEncoding { ascii, binary_little_endian };

struct PlyWriteOptions {
  PlyEncoding encoding = PlyEncoding::binary_little_endian;
  bool overwrite = false;
  Progress progress;  ///< in points
};

/// Writes a cloud as PLY: double x y z, then nx ny nz, red green blue (uchar), intensity (ushort) and the other
/// attributes and extra dimensions that are present, under the names other programs know.
/// Errors: as OutputFile.
void write_ply(const std::filesystem::path& path, const PointCloud& cloud, const PlyWriteOptions& options = {});

}  // namespace alidade
