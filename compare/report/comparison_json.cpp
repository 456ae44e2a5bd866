// SPDX-License-Identifier: MIT
#include "compare/report/comparison_json.h"

#include <fmt/format.h>

namespace alidade::compare {

Json thresholds_json(const Verdict& verdict) {
  Json thresholds = Json::array();
  for (const JudgedThreshold& judged : verdict.judged) {
    thresholds.push_back({{"threshold", to_text(judged.threshold)},
                          {"metric", judged.threshold.metric},
                          {"fails_if", judged.fails_below ? "below" : "above"},
                          {"limit", json_number(judged.threshold.limit)},
                          {"value", json_number(judged.value)},
                          {"fails", judged.fails}});
  }
  return thresholds;
}

Json regions_json(const ChangeRegions& changes) {
  Json regions = Json::array();
  for (const ChangeRegion& region : changes.regions) {
    regions.push_back({{"left", region.left},
                       {"top", region.top},
                       {"right", region.right},
                       {"bottom", region.bottom},
                       {"pixels", region.pixels},
                       {"strongest", json_number(region.strongest)},
                       {"mean", json_number(region.mean)},
                       {"at", {region.x, region.y}}});
  }
  return regions;
}

namespace {

const char* name_of(ToneMapper mapper) {
  return mapper == ToneMapper::aces ? "aces" : mapper == ToneMapper::hable ? "hable" : "reinhard";
}

const char* name_of(ChangeMap map) {
  return map == ChangeMap::flip ? "flip" : map == ChangeMap::color ? "color" : "depth";
}

std::string text_of(const image::PixelBox& box) {
  return fmt::format("{},{},{},{}", box.left, box.top, box.right, box.bottom);
}

std::string text_of(const std::vector<image::PixelBox>& boxes) {
  std::string text;
  for (const image::PixelBox& box : boxes) text += fmt::format("{}{}", text.empty() ? "" : " ", text_of(box));
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
    return fmt::format("no shift up to {} pixels stands out; correlation of edges {:.3f}", largest_shift,
                       found.score_unshifted);
  // No -0.00.
  const auto hundredths = [](double shift) { return std::round(100.0 * shift) / 100.0 + 0.0; };
  return fmt::format(
      "the test lies {:.2f} pixels to the right and {:.2f} down; correlation of edges {:.3f} there, "
      "{:.3f} without the shift",
      hundredths(found.shift_x), hundredths(found.shift_y), found.score, found.score_unshifted);
}

Json json_of(const image::PixelBox& box) {
  return {box.left, box.top, box.right, box.bottom};
}

Json json_of(const std::vector<image::PixelBox>& boxes) {
  Json json = Json::array();
  for (const image::PixelBox& box : boxes) json.push_back(json_of(box));
  return json;
}

/// The options alone, for programs: those that were given, and pixels_per_degree and tone_mapper of colours.
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

Json facts_json(const ComparedImageFacts& facts) {
  return {{"file", facts.file.string()},
          {"width", facts.width},
          {"height", facts.height},
          {"encoding", facts.encoding == ColorEncoding::display ? "display" : "linear"}};
}

Json errors_json(const ErrorMetrics& errors) {
  return {{"rmse", json_number(errors.rmse)},         {"psnr", json_number(errors.psnr)},
          {"mean", json_number(errors.mean)},         {"mean_abs", json_number(errors.mean_abs)},
          {"p95", json_number(errors.percentile_95)}, {"max_abs", json_number(errors.max_abs)}};
}

Json flip_json(const FlipResult& flip) {
  Json json{{"mean", json_number(flip.mean)},
            {"weighted_median", json_number(flip.weighted_median)},
            {"weighted_first_quartile", json_number(flip.weighted_first_quartile)},
            {"weighted_third_quartile", json_number(flip.weighted_third_quartile)},
            {"min", json_number(flip.min)},
            {"max", json_number(flip.max)}};
  if (flip.exposures > 0) {
    json["start_exposure"] = json_number(flip.start_exposure);
    json["stop_exposure"] = json_number(flip.stop_exposure);
    json["exposures"] = flip.exposures;
  }
  return json;
}

Json color_json(const ColorFigures& color) {
  Json json = errors_json(color.stored);
  json["max_at"] = {color.stored.max_x, color.stored.max_y, color.stored.max_channel};
  json["linear"] = errors_json(color.linear);
  json["display"] = errors_json(color.display);
  json["ssim"] = json_number(color.ssim);
  json["ms_ssim"] = json_number(color.ms_ssim);
  json["flip"] = flip_json(color.flip);
  return json;
}

/// Figures of layers, under the names that thresholds and tables have for them.
void add_layers(Json& metrics, const Comparison& comparison) {
  for (const Metric& metric : metrics_of(comparison))
    if (metric.kind->group == k_depth_group || metric.kind->group == k_normal_group ||
        metric.kind->group == k_id_group || metric.kind->group == k_alpha_group) {
      const std::string name(metric.kind->name);
      metrics[name] = json_number(metric.value);
      if (metric.position) metrics[name + "_at"] = {metric.position->x, metric.position->y};
    }
}

Json match_json(const Comparison& comparison) {
  const ColorMatch& match = *comparison.match;
  return {{"scale", {match.scale.x, match.scale.y, match.scale.z}},
          {"offset", {match.offset.x, match.offset.y, match.offset.z}},
          {"inliers", match.inliers},
          {"metrics", color_json(*comparison.matched)}};
}

Json alignment_json(const Alignment& alignment) {
  return {{"shift", {alignment.shift_x, alignment.shift_y}},
          {"score", json_number(alignment.score)},
          {"score_unshifted", json_number(alignment.score_unshifted)},
          {"certain", alignment.is_certain}};
}

Json changes_json(const ChangeRegions& changes) {
  return {{"changed_pixels", changes.changed_pixels},
          {"listed_pixels", changes.listed_pixels},
          {"left_out_regions", changes.small_regions + changes.further_regions},
          {"small_regions", changes.small_regions},
          {"further_regions", changes.further_regions},
          {"regions", regions_json(changes)}};
}

Json whole_json(const Comparison& comparison, const Verdict& verdict, const Verdict& warnings) {
  Json metrics = Json::object();
  if (comparison.color) metrics = color_json(*comparison.color);
  add_layers(metrics, comparison);
  Json json{{"reference", facts_json(comparison.reference)},
            {"test", facts_json(comparison.test)},
            {"pixels", comparison.pixels},
            {"counted", comparison.counted},
            {"excluded", comparison.excluded},
            {"how", how_json(comparison)},
            {"metrics", metrics}};
  if (comparison.match) json["match"] = match_json(comparison);
  if (comparison.alignment) json["alignment"] = alignment_json(*comparison.alignment);
  if (comparison.changes) json["changes"] = changes_json(*comparison.changes);
  json["remarks"] = comparison.remarks;
  json["thresholds"] = thresholds_json(verdict);
  json["warnings"] = thresholds_json(warnings);
  json["pass"] = verdict.pass();
  return json;
}

}  // namespace

std::vector<HowLine> how_lines(const Comparison& comparison) {
  const ComparisonOptions& options = comparison.options;
  std::vector<HowLine> lines;
  const auto add = [&](const char* name, std::string text) { lines.push_back({name, std::move(text)}); };
  if (options.crop)
    add("Part", text_of(*options.crop) + " of both; positions count from its top left corner");
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

std::string comparison_json(const Comparison& comparison, const Verdict& verdict, const Verdict& warnings) {
  return json_text(whole_json(comparison, verdict, warnings), 2) + "\n";
}

std::string batch_json(const std::vector<PairOutcome>& outcomes) {
  Json pairs = Json::array();
  std::size_t failed = 0;
  for (const PairOutcome& outcome : outcomes) {
    failed += !outcome.pass();
    Json pair{{"name", outcome.pair.name}};
    if (outcome.comparison) {
      pair.update(whole_json(*outcome.comparison, outcome.verdict, outcome.warnings));
    } else {
      pair["error"] = outcome.error;
      pair["pass"] = false;
    }
    pairs.push_back(pair);
  }
  return json_text(Json{{"pairs", pairs}, {"failed", failed}, {"pass", failed == 0}}, 2) + "\n";
}

}  // namespace alidade::compare
