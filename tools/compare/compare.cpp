// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <new>

#include "base/error.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "compare/batch.h"
#include "compare/change_regions.h"
#include "compare/comparison.h"
#include "compare/difference_map.h"
#include "compare/report/comparison_json.h"
#include "compare/report/page.h"
#include "compare/report/report_page.h"
#include "compare/verdict.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/compare/compare_options.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;

std::string facts_text(const char* side, const compare::ComparedImageFacts& facts) {
  return fmt::format("{:<10} {}  {} x {}, {}\n", side, line_text(facts.file.string()), facts.width,
                     facts.height,
                     facts.encoding == compare::ColorEncoding::display ? "display" : "linear light");
}

std::string regions_text(const compare::ChangeRegions& changes) {
  constexpr std::size_t k_most_lines = 10;
  std::string text = fmt::format("\nRegions of change: {}, with {} of {} changed pixels\n",
                                 changes.regions.size(), changes.listed_pixels, changes.changed_pixels);
  for (std::size_t i = 0; i < std::min(k_most_lines, changes.regions.size()); ++i) {
    const compare::ChangeRegion& region = changes.regions[i];
    text += fmt::format("  {:>3}  {} pixels in {},{},{},{}, strongest {:.4g} at {},{}\n", i + 1,
                        region.pixels, region.left, region.top, region.right, region.bottom, region.strongest,
                        region.x, region.y);
  }
  if (changes.regions.size() > k_most_lines)
    text += fmt::format("  and {} more, see --json or --report\n", changes.regions.size() - k_most_lines);
  return text;
}

/// "flip=0.05: 0.08", for those that fail.
std::vector<std::string> failures_of(const compare::Verdict& verdict) {
  std::vector<std::string> failures;
  for (const compare::JudgedThreshold& judged : verdict.judged)
    if (judged.fails)
      failures.push_back(fmt::format("{}: {:.6g}", compare::to_text(judged.threshold), judged.value));
  return failures;
}

/// The table that people read on a terminal.
std::string comparison_text(const compare::Comparison& comparison, const compare::Verdict& verdict) {
  std::string text = facts_text("reference", comparison.reference) + facts_text("test", comparison.test);
  text += fmt::format("{:<10} {} of {} pixels", "counted", comparison.counted, comparison.pixels);
  text += comparison.excluded > 0 ? fmt::format(", {} of them without finite colours\n", comparison.excluded)
                                  : "\n";
  std::string_view group;
  for (const compare::Metric& metric : compare::metrics_of(comparison)) {
    if (metric.kind->group != group) {
      group = metric.kind->group;
      text += fmt::format("\n{}\n", group);
    }
    text += fmt::format("  {:<18} {:>12.6g} {:<4} {}\n", metric.kind->name, metric.value, metric.kind->unit,
                        metric.kind->label);
    if (metric.position)
      text.insert(text.size() - 1, fmt::format(" at {},{}", metric.position->x, metric.position->y));
  }
  const std::vector<compare::HowLine> how = compare::how_lines(comparison);
  if (!how.empty()) text += "\nHow it was compared\n";
  for (const compare::HowLine& line : how)
    text += fmt::format("  {:<18} {}\n", line.name, line_text(line.text));
  if (comparison.changes) text += regions_text(*comparison.changes);
  if (verdict.judged.empty()) return text;
  text += "\nThresholds\n";
  for (const compare::JudgedThreshold& judged : verdict.judged)
    text += fmt::format("  {:<18} {:>12.6g}      {}\n", compare::to_text(judged.threshold), judged.value,
                        judged.fails ? "FAILS" : "kept");
  return text + (verdict.pass() ? "pass\n" : "FAIL\n");
}

/// A line per pair, worst first, and one for all pairs.
std::string batch_text(const std::vector<compare::PairOutcome>& outcomes) {
  std::string text = fmt::format("{:<5} {:>10} {:>10} {:>10}  pair\n", "", "flip", "ssim", "psnr");
  std::size_t failed = 0;
  for (const compare::PairOutcome& outcome : outcomes) {
    failed += !outcome.pass();
    if (!outcome.comparison) {
      text += fmt::format("{:<5} {:>10} {:>10} {:>10}  {}: {}\n", "ERROR", "", "", "",
                          line_text(outcome.pair.name), line_text(outcome.error));
      continue;
    }
    text += fmt::format("{:<5}", outcome.pass() ? "pass" : "FAIL");
    for (const char* const name : {"flip", "ssim", "psnr"}) {
      const std::optional<double> value = compare::find_metric(name)->value(*outcome.comparison);
      text += fmt::format(" {:>10}", value ? fmt::format("{:.5g}", *value) : "-");
    }
    text += "  " + line_text(outcome.pair.name);
    for (const std::string& failure : failures_of(outcome.verdict)) text += "; " + failure;
    text += "\n";
  }
  return text + fmt::format("{} of {} pairs {}\n", failed == 0 ? outcomes.size() : failed, outcomes.size(),
                            failed == 0 ? "pass" : "fail");
}

ExitCode exit_code(const CompareRequest& request, bool pass, bool warned) {
  if (!pass) return request.idiff_codes ? ExitCode::failed : ExitCode::no;
  return request.idiff_codes && warned ? ExitCode::no : ExitCode::done;
}

/// The exit code of the worst pair.
ExitCode exit_code(const CompareRequest& request, const std::vector<compare::PairOutcome>& outcomes) {
  bool pass = true, warned = false, only_sizes = true, any_error = false;
  for (const compare::PairOutcome& outcome : outcomes) {
    pass = pass && outcome.pass();
    warned = warned || !outcome.warnings.pass();
    if (outcome.error.empty()) continue;
    any_error = true;
    only_sizes = only_sizes && outcome.sizes_differ;
  }
  if (!any_error) return exit_code(request, pass, warned);
  if (!request.idiff_codes) return ExitCode::failed;
  return only_sizes ? ExitCode::sizes_differ : ExitCode::unreadable;
}

/// A file of points behind regions of change.
struct PointsOutput {
  fs::path file;
  PointCloud points;
};

/// Errors: no layer of ids; a cloud that cannot be read or is another one.
void find_points(std::vector<PointsOutput>& outputs, const CompareRequest& request,
                 const RegionPointsRequest& points, const compare::ComparedImageFacts& facts,
                 const compare::ChangeRegions& changes) {
  if (points.output.empty()) return;
  if (facts.ids.empty())
    throw file_error(facts.file, "no layer of point ids", "an EXR file rendered with the layer id");
  const PointCloud cloud = with_progress("reading", "B", request.verbosity, [&](const Progress& progress) {
    return read_cloud(resolve_clouds(std::vector{points.cloud}, cloud_formats()),
                      {.partial = request.partial, .progress = progress});
  });
  const std::vector<compare::RegionPoint> found =
      compare::region_points(facts.ids, changes, cloud.positions.size());
  if (found.empty()) {
    say_warning(fmt::format("the regions contain no points of {}; not writing {}", points.cloud.string(),
                            points.output.string()));
    return;
  }
  outputs.push_back({points.output, compare::points_of_regions(cloud, found)});
}

/// A file of a map.
struct MapOutput {
  fs::path file;
  const compare::DifferenceMap* map;
};

/// Errors: the images have no such map.
std::vector<MapOutput> maps_to_write(const CompareRequest& request, const compare::ComparisonImages& images) {
  std::vector<MapOutput> outputs;
  const auto add = [&](const fs::path& file, const std::optional<compare::DifferenceMap>& map,
                       const char* lacking) {
    if (file.empty()) return;
    if (!map) throw file_error(file, "this map cannot be computed from these images", lacking);
    outputs.push_back({file, &*map});
  };
  add(request.color_map, images.color_map, "two images with colours");
  add(request.flip_map, images.flip_map, "two images with colours");
  add(request.depth_map, images.depth_map, "two images with the layer Z");
  add(request.agreement_map, images.agreement_map,
      "two images with the layer Z, at least one of them with depth.sigma (render --layers "
      "color,depth,depth.sigma)");
  return outputs;
}

/// Reports all errors but write failures before it writes the first file.
void write_files(const CompareRequest& request, const compare::Comparison& comparison,
                 const compare::Verdict& verdict, const compare::Verdict& warnings) {
  std::string page;
  if (!request.report.empty())
    page = compare::report_page(comparison, verdict, request.packing.value_or(image::ImagePacking::automatic),
                                warnings);
  std::vector<MapOutput> maps;
  if (comparison.images) maps = maps_to_write(request, *comparison.images);
  std::vector<PointsOutput> points;
  if (comparison.changes) {
    find_points(points, request, request.reference_points, comparison.reference, *comparison.changes);
    find_points(points, request, request.test_points, comparison.test, *comparison.changes);
  }
  // Maps first: they need a font, which may be missing.
  for (const MapOutput& map : maps) compare::write_difference(*map.map, map.file, request.overwrite);
  if (!request.report.empty()) write_text_file(request.report, page, request.overwrite);
  for (const PointsOutput& output : points) {
    write_las(output.file, output.points, {.overwrite = request.overwrite});
    say_note(request.verbosity,
             fmt::format("wrote {} points to {}", output.points.size(), output.file.string()));
  }
}

ExitCode compare_one(const CompareRequest& request) {
  compare::ComparisonOptions options = request.comparison;
  options.keep_images = !request.report.empty() || request.has_maps();
  const compare::Comparison comparison =
      with_progress("comparing", "pixels", request.verbosity, [&](const Progress& progress) {
        return compare::compare_files(request.reference, request.test, options, progress);
      });
  const compare::Verdict verdict = compare::judge(comparison, request.fail_above),
                         warnings = compare::judge(comparison, request.warn_above);
  write_files(request, comparison, verdict, warnings);
  if (request.verbosity != Verbosity::quiet) {
    for (const std::string& remark : comparison.remarks) say_note(remark);
    for (const std::string& failure : failures_of(warnings)) say_warning("beyond " + failure);
  }
  write_to_stdout(request.json ? compare::comparison_json(comparison, verdict, warnings)
                               : comparison_text(comparison, verdict));
  return exit_code(request, verdict.pass(), !warnings.pass());
}

ExitCode compare_many(const CompareRequest& request) {
  const std::vector<compare::ImagePair> pairs =
      request.pairs.empty() ? compare::pairs_of_folders(request.reference, request.test)
                            : compare::read_pairs(request.pairs);
  check_pairs(request, pairs);
  const compare::BatchOptions options{.comparison = request.comparison,
                                      .fail_above = request.fail_above,
                                      .warn_above = request.warn_above,
                                      .keep_thumbnails = !request.report.empty(),
                                      .reports = request.reports,
                                      .packing = request.packing.value_or(image::ImagePacking::automatic),
                                      .overwrite = request.overwrite,
                                      .kept = {request.pairs, request.comparison.mask, request.report}};
  const std::vector<compare::PairOutcome> outcomes = with_progress(
      "comparing", "pairs", request.verbosity,
      [&](const Progress& progress) { return compare::compare_pairs(pairs, options, progress); });
  if (!request.report.empty()) {
    const bool is_table = !request.pairs.empty();
    const std::string page =
        compare::summary_page(outcomes, is_table ? request.pairs.string() : request.reference.string(),
                              is_table ? request.pairs.string() : request.test.string(), request.report);
    write_text_file(request.report, page, request.overwrite);
  }
  write_to_stdout(request.json ? compare::batch_json(outcomes) : batch_text(outcomes));
  if (request.verbosity != Verbosity::quiet)
    for (const compare::PairOutcome& outcome : outcomes)
      for (const std::string& failure : failures_of(outcome.warnings))
        say_warning(outcome.pair.name + " exceeds " + failure);
  return exit_code(request, outcomes);
}

ExitCode run(const CompareRequest& request) {
  check_request(request);
  return is_batch(request) ? compare_many(request) : compare_one(request);
}

/// run(), with errors as exit codes if those of idiff are requested, whose 2 is a difference and not an
/// error.
ExitCode run_with_codes(const CompareRequest& request) {
  if (!request.idiff_codes) return run(request);
  try {
    return run(request);
  } catch (const Cancelled&) {
    throw;
  } catch (const compare::SizeMismatch& error) {
    say_error(error.what());
    return ExitCode::sizes_differ;
  } catch (const std::bad_alloc&) {
    say_error("not enough memory");
  } catch (const std::exception& error) {
    say_error(error.what());
  }
  return ExitCode::unreadable;
}

/// The names of thresholds with what they are, as lines.
std::string names_of_metrics() {
  std::string text;
  std::string_view group;
  for (const compare::MetricKind& kind : compare::metric_kinds()) {
    if (kind.group != group) text += fmt::format("  {}\n", group = kind.group);
    text += manual_row(fmt::format("    {}", kind.name), kind.note, 23);
  }
  return text;
}

}  // namespace

Command add_compare(const Options& program) {
  auto request = std::make_shared<CompareRequest>();
  const Options compare =
      program.command("compare", "Compare an image with a reference: metrics, maps, regions, report");
  add_compare_options(compare, *request);
  compare.manual(fmt::format(fmt::runtime(manual("compare")), fmt::arg("metrics", names_of_metrics())));
  return command_of(compare, request, run_with_codes);
}

}  // namespace alidade::tools
