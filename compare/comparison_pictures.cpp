// SPDX-License-Identifier: MIT
#include "compare/comparison_pictures.h"

#include <algorithm>

#include "compare/displayed_picture.h"

namespace alidade {
namespace {

/// Few enough that the 8-bit codes of small differences leave no gaps.
constexpr std::size_t k_bins = 24;

/// What a screen shows, from black to white: Rec. 709's weights on sRGB values.
std::vector<float> lightness_of(const BytePicture& picture) {
  std::vector<float> lightness(picture.bytes.size() / 3);
  for (std::size_t i = 0; i < lightness.size(); ++i) {
    const std::uint8_t* const rgb = &picture.bytes[3 * i];
    lightness[i] = (0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]) / 255.0f;
  }
  return lightness;
}

void add_map(ComparisonPictures& pictures, std::optional<DifferenceMap>& place, DifferenceMap map,
             const char* unit) {
  const double low = map.range.low, high = map.range.high;
  if (low < high)
    pictures.histograms.push_back(
        {map.title, unit, low, high, count_values(map.title, map.values, map.mask, low, high, k_bins)});
  place = std::move(map);
}

}  // namespace

std::vector<const DifferenceMap*> ComparisonPictures::maps() const {
  std::vector<const DifferenceMap*> maps;
  for (const std::optional<DifferenceMap>* map : {&flip_map, &color_map, &depth_map})
    if (*map) maps.push_back(&**map);
  return maps;
}

ComparisonPictures shown_pictures(const ComparedPair& pair) {
  const double farthest = std::max(farthest_depth(pair.reference), farthest_depth(pair.test));
  ComparisonPictures pictures;
  pictures.reference = displayed(pair.reference, farthest);
  pictures.test = displayed(pair.test, farthest);
  return pictures;
}

void add_maps(ComparisonPictures& pictures, const ComparedPair& pair, PairMaps made,
              std::vector<float> flip) {
  const ImageMask& mask = pair.mask;
  if (pair.have_colors()) {
    const char* const matched = pictures.matched ? ", colours matched" : "";
    const auto add_color_map = [&](std::optional<DifferenceMap>& place, DifferenceMap map) {
      map.title += matched;
      add_map(pictures, place, std::move(map), "");
    };
    add_color_map(pictures.flip_map, flip_difference(std::move(flip), pair.reference.width, mask));
    add_color_map(pictures.color_map,
                  made.color ? std::move(*made.color) : color_difference(pair.reference, pair.test, mask));
    const BytePicture& test = pictures.matched ? *pictures.matched : pictures.test;
    pictures.histograms.push_back(
        {"Lightness", "", 0.0, 1.0,
         count_values("reference", lightness_of(pictures.reference), mask, 0.0, 1.0),
         count_values(std::string("test") + matched, lightness_of(test), mask, 0.0, 1.0)});
  }
  if (pair.have_depth())
    add_map(pictures, pictures.depth_map,
            made.depth ? std::move(*made.depth) : depth_difference(pair.reference, pair.test, mask), "m");
}

}  // namespace alidade
