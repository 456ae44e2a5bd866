// SPDX-License-Identifier: MIT
#pragma once

#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/difference_map.h"
#include "compare/report/report_page.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "image/read_image.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/points/coverage_image.h"
#include "visibility/raster/map_image.h"

namespace alidade::tools {

/// The functions of the libraries that need OpenImageIO, which brings some 250 libraries: loading
/// these takes longer, and more memory, than all the work of most commands. So the functions are in a module
/// beside the program, and only a command that needs one loads it. Their contracts are those of their
/// headers. Only the module makes an ImageModule: the program would have to link the functions.
struct ImageModule {
  decltype(&image::library_version) image_library = &image::library_version;
  decltype(&image::write_image) write_image = &image::write_image;
  decltype(&image::write_legend) write_legend = &image::write_legend;
  decltype(&image::write_depth_map) write_depth_map = &image::write_depth_map;
  decltype(&image::write_depth_mask) write_depth_mask = &image::write_depth_mask;
  decltype(&image::read_sky_image) read_sky_image = &image::read_sky_image;
  decltype(&image::photo_size) photo_size = &image::photo_size;
  decltype(&image::read_photo) read_photo = &image::read_photo;
  decltype(&visibility::write_map_image) write_map_image = &visibility::write_map_image;
  decltype(&visibility::write_coverage_image) write_coverage_image = &visibility::write_coverage_image;
  decltype(&visibility::write_skyline) write_skyline = &visibility::write_skyline;
  decltype(&compare::compare_files) compare_files = &compare::compare_files;
  decltype(&compare::compare_pairs) compare_pairs = &compare::compare_pairs;
  decltype(&compare::report_page) report_page = &compare::report_page;
  decltype(&compare::write_difference) write_difference = &compare::write_difference;
};

/// Loads the module, which stays loaded. Errors: the module is missing where the program was built or
/// installed, or lacks a library; those of RemoteMap::check_all(), which the module cannot call for the
/// program: files that the module writes might be wrong.
const ImageModule& image_module();

}  // namespace alidade::tools
