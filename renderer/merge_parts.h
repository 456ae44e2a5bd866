// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

#include "image/film.h"
#include "image/image_file.h"
#include "renderer/checkpoint.h"
#include "renderer/image_metadata.h"

// Parts of an image that different machines have rendered, joined into the image that one would have
// rendered. Merging reads neither the scene nor the cloud: a part has all that the image file needs.
//
//   machine i of 20:  render_part(scene, &cloud, {.layers = ..., .part = {i, 20}},
//                                 {file, overwrite, image_entries(output, metadata)});
//   then:             const MergedImage merged = merge_parts(files, "picture.exr");
//                     image::write_image(merged.film, merged.output, merged.facts, overwrite);

namespace alidade::renderer {

/// What an image file holds besides its pixels, as entries of a fingerprint: its kind, layers, exposure, CRS
/// and metadata. The camera must be set.
Fingerprint image_entries(const image::OutputSettings& output, const ImageMetadata& metadata);

/// An image and all that write_image() needs.
struct MergedImage {
  image::Film film;
  image::OutputSettings output;
  image::ImageFacts facts;
  std::uint64_t samples_taken = 0;  ///< camera samples
  int parts = 0;
};

/// Reads the heads of the files alone. Errors: those of merge_parts() but for damage behind the heads.
void check_parts(std::span<const std::filesystem::path> files, const std::filesystem::path& image);

/// Joins the parts of an image, in any order, for an image file of this name, if it has one: the film and the
/// facts are those of one run. A part may be given again if it has the same samples. The files may be of
/// machines that use other folders for the image; all else that a fingerprint has must be equal.
///
/// Errors: not a part; unfinished; of another image than the first file, naming the first thing that
/// differs; twice with other samples; parts that are missing, by number; an image whose extension does not
/// fit (.exr for parts of an EXR, else .png, .jpg or .tif); damaged, cut short or too long. Memory: as
/// render(), and the heads of all parts.
MergedImage merge_parts(std::span<const std::filesystem::path> files, const std::filesystem::path& image);

}  // namespace alidade::renderer
