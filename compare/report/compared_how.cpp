// SPDX-License-Identifier: MIT
#include "compare/report/compared_how.h"

#include <fmt/format.h>

#include <cmath>

namespace alidade {
namespace {

const char* name_of(ToneMapper mapper) {
  return mapper == ToneMapper::aces ? "aces" : mapper == ToneMapper::hable ? "hable" : "reinhard";
}

const char* name_of(ChangeMap map) {
  return map == ChangeMap::flip ? "flip" : map == ChangeMap::color ? "color" : "depth";
}

std::string text_of(const PixelRectangle& box) {
  return fmt::format("{},{},{},{}", box.left, box.top, box.right, box.bottom);
}

std::string text_of(const std::vector<PixelRectangle>& boxes) {
  std::string text;
  for (const PixelRectangle& box : boxes) text += fmt::format("{}{}", text.empty() ? "" : " ", text_of(box));
  return text;
}

std::string flip_text(const FlipResult& flip, const FlipOptions& options) {
  std::string text = fmt::format("{:.2f} pixels per degree", options.pixels_per_degree);
  if (flip.exposures > 0)
    text +=
        fmt::format("; linear light over {} exposures from {:.2f} to {:.2f} stops, tone mapper {}",
                    flip.exposures, flip.start_exposure, flip.stop_exposure, name_of(options.tone_mapper));
  return text;
}

std::string match_text(const ColorMatch& match, ColorModel model) {
  std::string text = fmt::format("factors of red, green, blue {:.4g}, {:.4g}, {:.4g}", match.scale.x,
                                 match.scale.y, match.scale.z);
  if (model == ColorModel::affine)
    text += fmt::format("; offsets {:.4g}, {:.4g}, {:.4g}", match.offset.x, match.offset.y, match.offset.z);
  return text + fmt::format("; {:.0f} % of the blocks follow", 100.0 * match.inliers);
}

std::string alignment_text(const Alignment& found, int largest_shift) {
  if (!found.is_certain)
    return fmt::format("no shift up to {} pixels can be told; correlation of edges {:.3f}", largest_shift,
                       found.score_unshifted);
  // No -0.00.
  const auto hundredths = [](double shift) { return std::round(100.0 * shift) / 100.0 + 0.0; };
  return fmt::format(
      "the test lies {:.2f} pixels to the right and {:.2f} down; correlation of edges {:.3f} there, "
      "{:.3f} without the shift",
      hundredths(found.shift_x), hundredths(found.shift_y), found.score, found.score_unshifted);
}

Json json_of(const PixelRectangle& box) {
  return {box.left, box.top, box.right, box.bottom};
}

Json json_of(const std::vector<PixelRectangle>& boxes) {
  Json json = Json::array();
  for (const PixelRectangle& box : boxes) json.push_back(json_of(box));
  return json;
}

}  // namespace

std::vector<HowLine> how_lines(const Comparison& comparison) {
  const ComparisonOptions& options = comparison.options;
  std::vector<HowLine> lines;
  const auto add = [&](const char* name, std::string text) { lines.push_back({name, std::move(text)}); };
  if (options.crop)
    add("Part", text_of(*options.crop) + " of both; places are told from its top left corner");
  if (!options.mask.empty()) add("Mask", options.mask.filename().string());
  if (!options.keep.empty()) add("Only in", text_of(options.keep));
  if (!options.ignore.empty()) add("Ignored", text_of(options.ignore));
  if (options.use_alpha) add("Opaque", "pixels with an alpha below one half do not count");
  if (options.valid_depth) add("Depth", "pixels without depth do not count");
  if (options.ignore_sky) add("Sky", "pixels in which nobody sees a surface do not count");
  if (comparison.color) add("FLIP", flip_text(comparison.color->flip, options.flip));
  if (comparison.match) add("Matched colours", match_text(*comparison.match, *options.match));
  if (comparison.alignment) add("Alignment", alignment_text(*comparison.alignment, options.largest_shift));
  if (options.find_changes)
    add("Changes",
        fmt::format("{} above {:g}{}; regions of at least {} pixels", name_of(*options.find_changes),
                    options.changes.threshold, *options.find_changes == ChangeMap::depth ? " m" : "",
                    options.changes.least_pixels));
  return lines;
}

Json how_json(const Comparison& comparison) {
  const ComparisonOptions& options = comparison.options;
  Json json = Json::object();
  if (options.crop) json["crop"] = json_of(*options.crop);
  if (options.resize_to_reference) json["resize"] = "reference";
  if (!options.mask.empty()) json["mask"] = options.mask.string();
  if (!options.keep.empty()) json["only"] = json_of(options.keep);
  if (!options.ignore.empty()) json["ignore"] = json_of(options.ignore);
  if (options.use_alpha) json["opaque"] = true;
  if (options.valid_depth) json["valid_depth"] = true;
  if (options.ignore_sky) json["ignore_sky"] = true;
  if (comparison.color) {
    json["pixels_per_degree"] = json_number(options.flip.pixels_per_degree);
    json["tone_mapper"] = name_of(options.flip.tone_mapper);
  }
  if (options.match) json["match"] = *options.match == ColorModel::affine ? "affine" : "exposure";
  if (options.align) json["largest_shift"] = options.largest_shift;
  if (options.find_changes) {
    json["changes"] = name_of(*options.find_changes);
    json["change_threshold"] = json_number(options.changes.threshold);
    json["least_pixels"] = options.changes.least_pixels;
  }
  return json;
}

}  // namespace alidade
