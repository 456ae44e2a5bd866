// SPDX-License-Identifier: MIT
#include "compare/report/comparison_json.h"

#include "compare/report/compared_how.h"
#include "compare/report/json_parts.h"

namespace alidade {
namespace {

Json facts_json(const PictureFacts& facts) {
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

/// Figures of layers under the names of thresholds: whatever table has them, they are called the same.
void add_layers(Json& metrics, const Comparison& comparison) {
  for (const Metric& metric : metrics_of(comparison))
    if (metric.kind->group == k_depth_group || metric.kind->group == k_normal_group ||
        metric.kind->group == k_id_group || metric.kind->group == k_alpha_group) {
      const std::string name(metric.kind->name);
      metrics[name] = json_number(metric.value);
      if (metric.place) metrics[name + "_at"] = {metric.place->x, metric.place->y};
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
  return json_text({{"pairs", pairs}, {"failed", failed}, {"pass", failed == 0}}, 2) + "\n";
}

}  // namespace alidade
