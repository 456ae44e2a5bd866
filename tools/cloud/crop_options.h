// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "base/bounds.h"
#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// --crop and --crop-crs: which part of a cloud is wanted.
struct CropOptions {
  std::string text;                ///< as it was given; empty = all of the cloud
  std::optional<Bounds> box;       ///< x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1
  std::filesystem::path polygons;  ///< or a file of polygons
  std::string reference;           ///< --crop-crs, as ObserverReference::given

  bool given() const { return !text.empty(); }
};
void add_crop_options(CLI::App& command, CropOptions& options);

/// Finds what is wrong before a cloud is read. Errors: no such file; --crop-crs without a file.
void check_crop(const CropOptions& options);

/// Crops a cloud, which may lack the files outside the box (ReadOptions::region). Errors: as read_polygons()
/// of geo/read_polygons.h and load_module_function(); no point is left of a cloud that had some.
void crop(PointCloud& cloud, const CropOptions& options, const Progress& progress);

}  // namespace alidade
