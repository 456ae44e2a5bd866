// SPDX-License-Identifier: MIT
#include "jobs/compare/compare.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "cloud/las/write_las.h"
#include "compare/change_regions.h"
#include "compare/difference_map.h"
#include "compare/report/page.h"
#include "compare/report/report_page.h"
#include "compare/verdict.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

namespace fs = std::filesystem;

/// A map of differences that can be written.
struct MapKind {
  const char *name, *help;
  fs::path CompareRequest::*file;
  std::optional<compare::DifferenceMap> compare::ComparisonImages::*map;
  const char* needed;
};

constexpr MapKind k_maps[] = {
    {"--color-map", "image of the colour differences, with legend", &CompareRequest::color_map,
     &compare::ComparisonImages::color_map, "two images with colours"},
    {"--flip-map", "image of FLIP, with legend", &CompareRequest::flip_map,
     &compare::ComparisonImages::flip_map, "two images with colours"},
    {"--depth-map", "image of the depth differences, with legend", &CompareRequest::depth_map,
     &compare::ComparisonImages::depth_map, "two images with the layer Z"},
    {"--agreement-map",
     "image of where depths agree within three standard deviations (the layer depth.sigma, metres), differ, "
     "or were not scanned",
     &CompareRequest::agreement_map, &compare::ComparisonImages::agreement_map,
     "two images with the layer Z, at least one of them with depth.sigma (render --layers "
     "color,depth,depth.sigma)"}};

bool has_maps(const CompareRequest& request) {
  return std::ranges::any_of(k_maps, [&](const MapKind& kind) { return !(request.*kind.file).empty(); });
}

/// "LEFT,TOP,RIGHT,BOTTOM" in pixels.
image::PixelBox parse_rectangle(const std::string& text) {
  constexpr std::uint64_t k_farthest = 1 << 20;
  std::vector<int> numbers;
  for (const std::string& word : split_list(text, 4, "LEFT,TOP,RIGHT,BOTTOM in pixels, such as 0,0,600,400"))
    numbers.push_back(static_cast<int>(parse_count(word, 0, k_farthest)));
  const image::PixelBox rectangle{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom)
    throw UsageError("limits out of order; expected LEFT < RIGHT and TOP < BOTTOM, found '" + text + "'");
  return rectangle;
}

/// A repeatable field, all of whose thresholds hold.
void add_thresholds(const Fields& group, const std::string& name, const std::string& help,
                    std::vector<compare::Threshold>& thresholds) {
  group.values(name, "LIST", help, [&thresholds](const std::string& text) {
    try {
      const std::vector<compare::Threshold> more = compare::parse_thresholds(text);
      thresholds.insert(thresholds.end(), more.begin(), more.end());
    } catch (const Error& error) {
      throw UsageError(error.what());
    }
  });
}

void add_rectangles(const Fields& group, const std::string& name, const std::string& help,
                    std::vector<image::PixelBox>& rectangles) {
  group.values(name, "L,T,R,B", help,
               [&rectangles](const std::string& text) { rectangles.push_back(parse_rectangle(text)); });
}

void add_masks(const Fields& fields, compare::ComparisonOptions& options) {
  const Fields group = fields.group("Masks");
  group.value("--crop", "L,T,R,B",
              "compare only this part of both images: columns L to R - 1 and rows T to B - 1, in pixels from "
              "the top left",
              options.crop, parse_rectangle);
  group.choice("--resize",
               "for images of different size: none rejects them (default), reference resizes the test",
               options.resize_to_reference, {{"none", false}, {"reference", true}});
  group.file("--mask", "FILE", "image of the reference's size; only its light pixels count", options.mask);
  add_rectangles(group, "--only", "only pixels in this rectangle count; repeatable", options.keep);
  add_rectangles(group, "--ignore", "ignore pixels in this rectangle; repeatable", options.ignore);
  group.flag("--opaque", "only pixels with an alpha of at least one half count, in every image with alpha",
             options.use_alpha);
  group.flag("--valid-depth", "only pixels with finite depth above 0 count, in every image with depth",
             options.valid_depth);
  group.flag("--ignore-sky", "ignore pixels where both images have no surface", options.ignore_sky);
}

void add_photographs(const Fields& fields, compare::ComparisonOptions& options) {
  const Fields group = fields.group("Photographs");
  group.choice(
      "--match",
      "fit the colours of the test to the reference, and report the metrics of matched colours too: exposure "
      "is a factor per channel (exposure, white balance), affine an offset too (haze, black level)",
      options.match, {{"exposure", compare::ColorModel::exposure}, {"affine", compare::ColorModel::affine}});
  const Field align = group.flag("--align",
                                 "find the shift that best aligns the edges of both, to distinguish a "
                                 "misplaced camera from colours that differ",
                                 options.align);
  group.needs(align).count("--largest-shift", "PIXELS", "largest shift for --align, in pixels (default: 64)",
                           options.largest_shift, 1, 4096);
}

void add_flip(const Fields& fields, compare::FlipOptions& flip) {
  const Fields group = fields.group("FLIP");
  group.number(
      "--pixels-per-degree", "N",
      "of the field of view (default: 67.02: a screen 0.7 m wide with 3840 pixels at a distance of 0.7 m)",
      flip.pixels_per_degree, 1.0, 1000.0);
  group.choice("--tone-mapper", "for linear light (default: aces)", flip.tone_mapper,
               {{"aces", compare::ToneMapper::aces},
                {"hable", compare::ToneMapper::hable},
                {"reinhard", compare::ToneMapper::reinhard}});
  group.number("--start-exposure", "STOPS",
               "the darkest exposure of linear light, in stops (default: from the reference)",
               flip.start_exposure, -1000.0, 1000.0);
  group.number("--stop-exposure", "STOPS", "the brightest exposure, in stops (default: from the reference)",
               flip.stop_exposure, -1000.0, 1000.0);
  group.count("--exposures", "N", "number of exposures (default: one per stop)", flip.exposures, 2, 256);
}

void add_changes(const Fields& fields, CompareRequest& request) {
  const Fields group = fields.group("Regions of change");
  compare::ComparisonOptions& options = request.comparison;
  const Field changes = group.choice(
      "--changes",
      "list regions of changed pixels by size: changed in FLIP, in colour (0 to 1), or in depth (metres)",
      options.find_changes,
      {{"flip", compare::ChangeMap::flip},
       {"color", compare::ChangeMap::color},
       {"depth", compare::ChangeMap::depth}});
  group.needs(changes).number("--change-threshold", "VALUE", "pixels above it are changed (default: 0.2)",
                              options.changes.threshold, 0.0, 1e9);
  group.needs(changes).count("--least-pixels", "N", "omit regions with fewer changed pixels (default: 16)",
                             options.changes.least_pixels, 1, 1'000'000'000);
  group.file("--reference-points", "FILE.las|FILE.laz",
             "write the points of --reference-cloud in the regions; requires the layer id",
             request.reference_points.output);
  group.file("--reference-cloud", "CLOUD", "the cloud of the reference", request.reference_points.cloud);
  group.file("--test-points", "FILE.las|FILE.laz", "write the points of --test-cloud in the regions",
             request.test_points.output);
  group.file("--test-cloud", "CLOUD", "the cloud of the test", request.test_points.cloud);
  group.flag("--partial", "read the intact part of damaged clouds, for images rendered with --partial",
             request.partial);
}

/// Errors that need neither images nor clouds: missing or surplus operands, fields that exclude each other.
void check_request(const CheckedCompare& request) {
  const auto require = [](bool holds, const char* problem, const char* expected) {
    if (!holds) throw input_error(problem, expected);
  };
  const RegionPointsRequest &old_points = request.reference_points, &new_points = request.test_points;
  const bool has_points = !old_points.output.empty() || !new_points.output.empty();
  if (request.pairs.empty()) {
    require(!request.reference.empty() && !request.test.empty(), "nothing to compare",
            "REFERENCE and TEST, or --pairs FILE.csv");
  } else {
    require(request.reference.empty(), "REFERENCE, TEST and --pairs exclude each other",
            "REFERENCE and TEST, or --pairs FILE.csv");
  }
  const bool is_packed = request.packing != image::ImagePacking::automatic;
  if (request.is_batch) {
    require(!has_maps(request) && !has_points && old_points.cloud.empty() && new_points.cloud.empty(),
            "maps and points require a single pair of images", "--report or --reports for many");
    require(!is_packed || !request.reports.empty(), "--report-pictures requires reports of pairs",
            "--reports FOLDER");
    return;
  }
  require(request.reports.empty(), "--reports requires many pairs", "--report FILE.html");
  require(!is_packed || !request.report.empty(), "--report-pictures requires a report", "--report FILE.html");
  require(!has_points || request.comparison.find_changes, "points require regions of change",
          "--changes flip|color|depth with --reference-points or --test-points");
  for (const RegionPointsRequest& points : {old_points, new_points})
    require(points.cloud.empty() == points.output.empty(),
            "points of regions require a cloud and an output file",
            "--reference-cloud with --reference-points, --test-cloud with --test-points");
}

/// What the run writes, and reads beside images of many pairs.
PlannedWork work_of(const CompareRequest& request) {
  PlannedWork work{.reads = {request.reference, request.test, request.pairs, request.comparison.mask,
                             request.reference_points.cloud, request.test_points.cloud},
                   .writes = {request.report, request.reference_points.output, request.test_points.output}};
  for (const MapKind& kind : k_maps) work.writes.push_back(request.*kind.file);
  return work;
}

/// A file of points behind regions of change.
struct PointsOutput {
  fs::path file;
  PointCloud points;
};

/// Errors: no layer of ids; a cloud that cannot be read or is another one.
void find_points(std::vector<PointsOutput>& outputs, const RegionPointsRequest& points, bool partial,
                 const compare::ComparedImageFacts& facts, const compare::ChangeRegions& changes,
                 Listener& listener) {
  if (points.output.empty()) return;
  if (facts.ids.empty())
    throw file_error(facts.file, "no layer of point ids", "an EXR file rendered with the layer id");
  const PointCloud cloud =
      read_files(resolve_clouds({&points.cloud, 1}, cloud_formats()), partial, {}, listener);
  const std::vector<compare::RegionPoint> found =
      compare::region_points(facts.ids, changes, cloud.positions.size());
  if (found.empty()) {
    listener.warn_always(fmt::format("the regions contain no points of {}; not writing {}",
                                     points.cloud.string(), points.output.string()));
    return;
  }
  outputs.push_back({points.output, compare::points_of_regions(cloud, found)});
}

/// Reports all errors but write failures before it writes the first file.
void write_files(const CompareRequest& request, const compare::PairOutcome& outcome, Listener& listener) {
  const compare::Comparison& comparison = *outcome.comparison;
  std::string page;
  if (!request.report.empty())
    page = compare::report_page(comparison, outcome.verdict, request.packing, outcome.warnings);
  for (const MapKind& kind : k_maps)
    if (!(request.*kind.file).empty() && !((*comparison.images).*kind.map))
      throw file_error(request.*kind.file, "this map cannot be computed from these images", kind.needed);
  std::vector<PointsOutput> points;
  if (comparison.changes) {
    const auto find = [&](const RegionPointsRequest& wanted, const compare::ComparedImageFacts& facts) {
      find_points(points, wanted, request.partial, facts, *comparison.changes, listener);
    };
    find(request.reference_points, comparison.reference);
    find(request.test_points, comparison.test);
  }
  // Maps first: they need a font, which may be missing.
  for (const MapKind& kind : k_maps)
    if (!(request.*kind.file).empty())
      compare::write_difference(*((*comparison.images).*kind.map), request.*kind.file, request.overwrite);
  if (!request.report.empty()) write_text_file(request.report, page, request.overwrite);
  for (const PointsOutput& output : points) {
    write_las(output.file, output.points, {.overwrite = request.overwrite});
    listener.note(fmt::format("wrote {} points to {}", output.points.size(), output.file.string()));
  }
}

compare::PairOutcome compare_one(const CompareRequest& request, const compare::ImagePair& pair,
                                 Listener& listener) {
  compare::ComparisonOptions options = request.comparison;
  options.keep_images = options.keep_images || !request.report.empty() || has_maps(request);
  compare::PairOutcome outcome;
  outcome.pair = pair;
  outcome.comparison = in_stage(listener, "comparing", "pixels", [&](const Progress& progress) {
    return compare::compare_files(pair.reference, pair.test, options, progress);
  });
  outcome.verdict = compare::judge(*outcome.comparison, request.fail_above);
  outcome.warnings = compare::judge(*outcome.comparison, request.warn_above);
  write_files(request, outcome, listener);
  for (const std::string& remark : outcome.comparison->remarks) listener.note(remark);
  for (const std::string& failure : compare::failures(outcome.warnings)) listener.warn("beyond " + failure);
  return outcome;
}

CompareResult compare_many(const CheckedCompare& request, Listener& listener) {
  compare::BatchOptions options = request;
  options.keep_thumbnails = options.keep_thumbnails || !request.report.empty();
  options.kept.insert(options.kept.end(), {request.pairs, request.comparison.mask, request.report});
  CompareResult outcomes = in_stage(listener, "comparing", "pairs", [&](const Progress& progress) {
    return compare::compare_pairs(request.image_pairs, options, progress);
  });
  if (!request.report.empty()) {
    const bool is_table = !request.pairs.empty();
    const std::string page =
        compare::summary_page(outcomes, (is_table ? request.pairs : request.reference).string(),
                              (is_table ? request.pairs : request.test).string(), request.report);
    write_text_file(request.report, page, request.overwrite);
  }
  for (const compare::PairOutcome& outcome : outcomes)
    for (const std::string& failure : compare::failures(outcome.warnings))
      listener.warn(outcome.pair.name + " exceeds " + failure);
  return outcomes;
}

}  // namespace

void add_compare_fields(const Fields& fields, CompareRequest& request,
                        const std::function<void()>& add_answers) {
  fields.file("reference", "REFERENCE", "reference image, or folder of images", request.reference);
  fields.file("test", "TEST", "test image, or folder of images", request.test);
  fields.group("Pairs").file("--pairs", "FILE.csv",
                             "pairs of images instead of REFERENCE and TEST: CSV with the header "
                             "reference,test[,name], paths relative to its folder",
                             request.pairs);
  add_masks(fields, request.comparison);
  add_photographs(fields, request.comparison);
  add_flip(fields, request.comparison.flip);
  add_changes(fields, request);
  const Fields verdict = fields.group("Verdict");
  add_thresholds(verdict, "--fail-above",
                 "fail beyond these thresholds, such as flip=0.05,psnr<30: NAME=LIMIT fails if the metric is "
                 "worse, NAME<LIMIT if it is below, NAME>LIMIT if it is above; repeatable",
                 request.fail_above);
  add_thresholds(verdict, "--warn-above", "warn beyond these thresholds, in the same form; repeatable",
                 request.warn_above);
  add_answers();
  const Fields group = fields.group("Answers");
  group.file("--report", "FILE.html",
             "HTML report in one file without network access: images to swipe and blink, maps, regions, "
             "metrics; for many pairs a summary",
             request.report);
  group.file("--reports", "FOLDER", "for many pairs: one report each, in this folder", request.reports);
  group.choice(
      "--report-pictures",
      "how reports store images: lossless or at a fifth of the size (default: png up to 2 million pixels)",
      request.packing, {{"png", image::ImagePacking::png}, {"jpeg", image::ImagePacking::jpeg}});
  for (const MapKind& kind : k_maps) group.file(kind.name, "FILE.png", kind.help, request.*kind.file);
  group.flag("--overwrite", "replace existing files", request.overwrite);
}

ComparePlan plan(const CompareRequest& request) {
  CheckedCompare checked{request};
  std::error_code error;
  checked.is_batch = !request.pairs.empty() || fs::is_directory(request.reference, error) ||
                     fs::is_directory(request.test, error);
  check_request(checked);
  PlannedWork work = work_of(request);
  check_outputs(work, request.overwrite);
  if (!checked.is_batch) {
    checked.image_pairs = {{{}, request.reference, request.test}};
  } else {
    checked.image_pairs = request.pairs.empty() ? compare::pairs_of_folders(request.reference, request.test)
                                                : compare::read_pairs(request.pairs);
    work.reads = {request.pairs, request.comparison.mask};
    for (const compare::ImagePair& pair : checked.image_pairs)
      work.reads.insert(work.reads.end(), {pair.reference, pair.test});
    check_outputs(work, request.overwrite);
    work.writes.push_back(request.reports);
  }
  return ComparePlan(std::move(checked), std::move(work));
}

CompareResult run(const ComparePlan& plan, Listener& listener) {
  const CheckedCompare& request = plan.request();
  if (request.is_batch) return compare_many(request, listener);
  CompareResult result;
  result.push_back(compare_one(request, request.image_pairs.front(), listener));
  return result;
}

}  // namespace alidade::jobs
