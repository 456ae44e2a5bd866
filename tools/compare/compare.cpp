// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "compare/comparison_json.h"
#include "compare/page_parts.h"
#include "compare/region_points.h"
#include "octree/cloud/read_cloud.h"
#include "octree/error.h"
#include "tools/command.h"
#include "tools/compare/compare_module.h"
#include "tools/compare/compare_options.h"
#include "tools/compare/compare_text.h"
#include "tools/message.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

bool is_batch(const CompareRequest& request) {
  std::error_code error;
  return !request.pairs.empty() || fs::is_directory(request.reference, error) ||
         fs::is_directory(request.test, error);
}

void require(bool holds, const char* problem, const char* expected) {
  if (!holds) throw Error({.problem = problem, .expected = expected});
}

/// Errors that need no picture.
void check_request(const CompareRequest& request) {
  const bool has_both = !request.reference.empty() && !request.test.empty();
  require(request.pairs.empty() ? has_both : request.reference.empty(), "nothing to compare",
          "REFERENCE and TEST, or --pairs FILE.csv");
  if (is_batch(request)) {
    require(!request.has_maps() && !request.has_points(),
            "maps and points are written for one pair of pictures", "--report or --reports for many");
  } else {
    require(request.reports.empty(), "--reports is for many pairs", "--report FILE.html");
    require(!request.has_points() || request.comparison.find_changes,
            "points are those behind regions of change",
            "--changes flip|color|depth beside --reference-points or --test-points");
    for (const RegionPointsRequest& points : {request.reference_points, request.test_points})
      require(points.cloud.empty() == points.output.empty(),
              "points behind regions need both their cloud and their file",
              "--reference-cloud with --reference-points, --test-cloud with --test-points");
  }
  std::vector<fs::path> inputs;
  for (const fs::path& input : {request.reference, request.test, request.pairs, request.comparison.mask,
                                request.reference_points.cloud, request.test_points.cloud})
    if (!input.empty()) inputs.push_back(input);
  for (const fs::path& output : outputs_of(request)) {
    check_writable(output, request.overwrite, inputs);
    inputs.push_back(output);
  }
}

ExitCode exit_code(const CompareRequest& request, bool pass, bool warned) {
  if (!pass) return request.idiff_codes ? ExitCode::failed : ExitCode::no;
  return request.idiff_codes && warned ? ExitCode::no : ExitCode::done;
}

/// That of the worst pair.
ExitCode exit_code(const CompareRequest& request, const std::vector<PairOutcome>& outcomes) {
  bool pass = true, warned = false, only_sizes = true, any_error = false;
  for (const PairOutcome& outcome : outcomes) {
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

void write_points(const RegionPointsRequest& points, const PictureFacts& facts, const CompareRequest& request,
                  const ChangeRegions& changes) {
  if (points.output.empty()) return;
  if (facts.ids.empty())
    throw Error({.file = facts.file.string(),
                 .problem = "has no layer of point ids",
                 .expected = "an EXR file rendered with the layer id"});
  ProgressLine line("reading", "B", request.verbosity.verbosity());
  const PointCloud cloud = read_cloud(points.cloud, {.progress = line.callback()});
  line.finish();
  const std::vector<RegionPoint> found = region_points(facts.ids, changes, cloud.positions.size());
  if (found.empty()) {
    say_warning(fmt::format("the regions show no points of {}; {} is not written", points.cloud.string(),
                            points.output.string()));
    return;
  }
  write_region_points(points.output, cloud, found, request.overwrite);
  if (!request.verbosity.quiet)
    say_note(fmt::format("wrote {} points to {}", found.size(), points.output.string()));
}

void write_maps(const CompareRequest& request, const ComparisonPictures& pictures) {
  const auto write = [&](const fs::path& file, const std::optional<DifferenceMap>& map, const char* lacking) {
    if (file.empty()) return;
    if (!map)
      throw Error({.file = file.string(), .problem = "no such map of these pictures", .expected = lacking});
    load_difference_writer()(*map, file, request.overwrite);
  };
  write(request.color_map, pictures.color_map, "two pictures with colours");
  write(request.flip_map, pictures.flip_map, "two pictures with colours");
  write(request.depth_map, pictures.depth_map, "two pictures with the layer Z");
}

ExitCode compare_one(const CompareRequest& request) {
  ComparisonOptions options = request.comparison;
  options.keep_pictures = !request.report.empty() || request.has_maps();
  ProgressLine line("comparing", "pixels", request.verbosity.verbosity());
  Comparison comparison;
  load_file_comparer()(request.reference, request.test, options, line.callback(), comparison);
  line.finish();
  const Verdict verdict = judge(comparison, request.fail_above),
                warnings = judge(comparison, request.warn_above);
  if (!request.report.empty()) {
    std::string page;
    load_report_maker()(comparison, verdict, request.packing.value_or(PicturePacking::automatic), warnings,
                        page);
    write_page(page, request.report, request.overwrite);
  }
  if (request.has_maps()) write_maps(request, *comparison.pictures);
  write_points(request.reference_points, comparison.reference, request, *comparison.changes);
  write_points(request.test_points, comparison.test, request, *comparison.changes);
  if (!request.verbosity.quiet) {
    for (const std::string& remark : comparison.remarks) say_note(remark);
    for (const std::string& failure : failures_of(warnings)) say_warning("beyond " + failure);
  }
  write_to_stdout(request.json ? comparison_json(comparison, verdict, warnings)
                               : comparison_text(comparison, verdict));
  return exit_code(request, verdict.pass(), !warnings.pass());
}

ExitCode compare_many(const CompareRequest& request) {
  const std::vector<ImagePair> pairs =
      request.pairs.empty() ? pairs_of_folders(request.reference, request.test) : read_pairs(request.pairs);
  const BatchOptions options{.comparison = request.comparison,
                             .fail_above = request.fail_above,
                             .warn_above = request.warn_above,
                             .keep_thumbnails = !request.report.empty(),
                             .reports = request.reports,
                             .packing = request.packing.value_or(PicturePacking::automatic),
                             .overwrite = request.overwrite};
  ProgressLine line("comparing", "pairs", request.verbosity.verbosity());
  std::vector<PairOutcome> outcomes;
  load_pair_comparer()(pairs, options, line.callback(), outcomes);
  line.finish();
  if (!request.report.empty()) {
    const bool is_table = !request.pairs.empty();
    write_page(summary_page(outcomes, is_table ? request.pairs.string() : request.reference.string(),
                            is_table ? request.pairs.string() : request.test.string(), request.report),
               request.report, request.overwrite);
  }
  write_to_stdout(request.json ? batch_json(outcomes) : batch_text(outcomes));
  if (!request.verbosity.quiet)
    for (const PairOutcome& outcome : outcomes)
      for (const std::string& failure : failures_of(outcome.warnings))
        say_warning(outcome.pair.name + " is beyond " + failure);
  return exit_code(request, outcomes);
}

ExitCode run(const CompareRequest& request) {
  try {
    check_request(request);
    return is_batch(request) ? compare_many(request) : compare_one(request);
  } catch (const Error& error) {
    if (!request.idiff_codes) throw;
    say_error(error.what());
    return dynamic_cast<const SizeMismatch*>(&error) != nullptr ? ExitCode::sizes_differ
                                                                : ExitCode::unreadable;
  }
}

/// The names of thresholds with what they are, as lines.
std::string names_of_figures() {
  std::string text;
  std::string_view group;
  for (const MetricKind& kind : metric_kinds()) {
    if (kind.group != group) text += fmt::format("  {}\n", group = kind.group);
    text += fmt::format("    {:<18} {}\n", kind.name, kind.note);
  }
  return text;
}

}  // namespace

Command add_compare(CLI::App& program) {
  auto request = std::make_shared<CompareRequest>();
  CLI::App* const compare =
      program.add_subcommand("compare", "Judge a picture by a reference: figures, maps, regions, a page");
  add_compare_options(*compare, *request);
  compare->footer(
      "Form:\n"
      "  alidade compare REFERENCE TEST [OPTIONS]\n"
      "  alidade compare --pairs FILE.csv [OPTIONS]\n"
      "\n"
      "REFERENCE and TEST are pictures of any format that OpenImageIO reads, or two folders, of which "
      "pictures of the same\n"
      "name are compared, in parallel; those without a counterpart fail. Files of whole numbers hold sRGB "
      "codes, files of\n"
      "half or float numbers linear light, of which FLIP is computed over a range of exposures. Layers Z "
      "(metres), N and id\n"
      "of EXR files are compared too. NaN and infinite pixels are counted, told and left out.\n"
      "\n"
      "Names for thresholds, as in --json and tables:\n" +
      names_of_figures() +
      "\n"
      "Exit codes: 0 pass, or no thresholds; 1 beyond a threshold, which NaN always is; 2 anything wrong, "
      "also pictures of\n"
      "different size; of many pairs 2 if any cannot be compared, else 1 if any fails.\n"
      "\n"
      "Examples:\n"
      "  alidade compare reference.png render.png\n"
      "  alidade compare reference.exr render.exr --fail-above 'flip=0.05,psnr<30' --json\n"
      "  alidade compare photo.jpg render.png --match exposure --align --report photo.html\n"
      "  alidade compare before.exr after.exr --changes depth --reference-cloud before.las "
      "--reference-points gone.las\n"
      "  alidade compare expected/ rendered/ --fail-above flip=0.02 --report summary.html --reports pages\n");
  return {compare, [request] {
            ExitCode code = ExitCode::failed;
            with_threads(request->threads, [&] { code = run(*request); });
            return code;
          }};
}

}  // namespace alidade
