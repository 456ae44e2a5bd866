// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/compared_image.h"
#include "compare/comparison.h"
#include "image/encoded_image.h"

namespace alidade::compare {

/// Two images of one size and the mask of pixels that count.
struct ComparedPair {
  ComparedImage reference, test;
  ImageMask mask;

  bool have_colors() const { return !reference.color.empty() && !test.color.empty(); }
  bool have_depth() const { return !reference.depth.empty() && !test.depth.empty(); }
};

/// Reads both, then resizes the test, masks and crops by the options. `remarks` gets the differences of
/// sizes, layers and encodings. Errors: those of compare_files() that concern files, sizes, masks and crops.
ComparedPair read_compared_pair(const std::filesystem::path& reference, const std::filesystem::path& test,
                                const ComparisonOptions& options, std::vector<std::string>& remarks);

/// An image as a screen shows it: its colours in sRGB, cut off at black and white. Without colours its
/// normals (x, y, z from -1 .. 1 as red, green, blue), else its depth (white at 0, black at `farthest` and
/// beyond), else its ids (every point has a colour of its own). NaN is black.
image::ByteImage displayed(const ComparedImage& image, double farthest);

/// Both images as screens show them. To be called before colours are matched.
ComparisonImages shown_images(const ComparedPair& pair);

/// Maps of a pair that were made for something else, or are still to be made.
struct PairMaps {
  std::optional<DifferenceMap> color, depth;
};

/// Adds maps and histograms of the layers that the pair has, and uses those of `made`. `flip`: map of FLIP,
/// if there are colours. If the test has matched colours (images.matched), titles mention it.
void add_maps(ComparisonImages& images, const ComparedPair& pair, PairMaps made, std::vector<float> flip);

}  // namespace alidade::compare
