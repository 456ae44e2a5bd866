// SPDX-License-Identifier: MIT
#include "tools/compare/compare_options.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;

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

/// A repeatable option, all of whose thresholds hold.
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

void add_masks(const Fields& command, compare::ComparisonOptions& options) {
  const Fields group = command.group("Masks");
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

void add_photographs(const Fields& command, compare::ComparisonOptions& options) {
  const Fields group = command.group("Photographs");
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

void add_flip(const Fields& command, compare::FlipOptions& flip) {
  const Fields group = command.group("FLIP");
  group.number(
      "--pixels-per-degree", "N",
      "of the field of view (default: 67.02: a screen 0.7 m wide with 3840 pixels at a distance of 0.7 m)",
      flip.pixels_per_degree, 1.0, 1000.0);
  group.choice("--tone-mapper", "for linear light (default: aces)", flip.tone_mapper,
               {{"aces", compare::ToneMapper::aces},
                {"hable", compare::ToneMapper::hable},
                {"reinhard", compare::ToneMapper::reinhard}});
  const auto add_exposure = [&](const char* name, const char* help, std::optional<double>& exposure) {
    group.number(name, "STOPS", help, exposure, -1000.0, 1000.0);
  };
  add_exposure("--start-exposure",
               "the darkest exposure of linear light, in stops (default: from the reference)",
               flip.start_exposure);
  add_exposure("--stop-exposure", "the brightest exposure, in stops (default: from the reference)",
               flip.stop_exposure);
  group.count("--exposures", "N", "number of exposures (default: one per stop)", flip.exposures, 2, 256);
}

void add_changes(const Fields& command, CompareRequest& request) {
  const Fields group = command.group("Regions of change");
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

void add_verdict(const Fields& command, CompareRequest& request) {
  const Fields group = command.group("Verdict");
  add_thresholds(group, "--fail-above",
                 "fail beyond these thresholds, such as flip=0.05,psnr<30: NAME=LIMIT fails if the metric is "
                 "worse, NAME<LIMIT if it is below, NAME>LIMIT if it is above; repeatable",
                 request.fail_above);
  add_thresholds(group, "--warn-above", "warn beyond these thresholds, in the same form; repeatable",
                 request.warn_above);
  group.flag("--idiff-codes",
             "exit codes of OpenImageIO's idiff: 0 pass, 1 warning, 2 fail, 3 sizes differ, 4 other errors; "
             "invalid options remain 2",
             request.idiff_codes);
}

void add_answers(const Fields& command, CompareRequest& request) {
  const Fields group = command.group("Answers");
  group.flag("--json", "print the result as JSON instead of a table", request.json);
  group.file("--report", "FILE.html",
             "HTML report in one file without network access: images to swipe and blink, maps, regions, "
             "metrics; for many pairs a summary",
             request.report);
  group.file("--reports", "FOLDER", "for many pairs: one report each, in this folder", request.reports);
  group.choice(
      "--report-pictures",
      "how reports store images: lossless or at a fifth of the size (default: png up to 2 million pixels)",
      request.packing, {{"png", image::ImagePacking::png}, {"jpeg", image::ImagePacking::jpeg}});
  group.file("--color-map", "FILE.png", "image of the colour differences, with legend", request.color_map);
  group.file("--flip-map", "FILE.png", "image of FLIP, with legend", request.flip_map);
  group.file("--depth-map", "FILE.png", "image of the depth differences, with legend", request.depth_map);
  group.file("--agreement-map", "FILE.png",
             "image of where depths agree within three standard deviations (the layer depth.sigma, metres), "
             "differ, or were not scanned",
             request.agreement_map);
  group.flag("--overwrite", "replace existing files", request.overwrite);
}

/// Files that the run writes, all of them.
std::vector<std::filesystem::path> outputs_of(const CompareRequest& request) {
  return {request.report,
          request.color_map,
          request.flip_map,
          request.depth_map,
          request.agreement_map,
          request.reference_points.output,
          request.test_points.output};
}

void require(bool holds, const char* problem, const char* expected) {
  if (!holds) throw input_error(problem, expected);
}

void check_words(const CompareRequest& request) {
  if (request.pairs.empty()) {
    require(!request.reference.empty() && !request.test.empty(), "nothing to compare",
            "REFERENCE and TEST, or --pairs FILE.csv");
  } else {
    require(request.reference.empty(), "REFERENCE, TEST and --pairs exclude each other",
            "REFERENCE and TEST, or --pairs FILE.csv");
  }
}

void check_batch_options(const CompareRequest& request) {
  const bool has_clouds = !request.reference_points.cloud.empty() || !request.test_points.cloud.empty();
  require(!request.has_maps() && !request.has_points() && !has_clouds,
          "maps and points require a single pair of images", "--report or --reports for many");
  require(!request.packing || !request.reports.empty(), "--report-pictures requires reports of pairs",
          "--reports FOLDER");
}

void check_pair_options(const CompareRequest& request) {
  require(request.reports.empty(), "--reports requires many pairs", "--report FILE.html");
  require(!request.packing || !request.report.empty(), "--report-pictures requires a report",
          "--report FILE.html");
  require(!request.has_points() || request.comparison.find_changes, "points require regions of change",
          "--changes flip|color|depth with --reference-points or --test-points");
  for (const RegionPointsRequest& points : {request.reference_points, request.test_points})
    require(points.cloud.empty() == points.output.empty(),
            "points of regions require a cloud and an output file",
            "--reference-cloud with --reference-points, --test-cloud with --test-points");
}

}  // namespace

void add_compare_options(const Fields& command, CompareRequest& request) {
  command.file("reference", "REFERENCE", "reference image, or folder of images", request.reference);
  command.file("test", "TEST", "test image, or folder of images", request.test);
  command.group("Pairs").file("--pairs", "FILE.csv",
                              "pairs of images instead of REFERENCE and TEST: CSV with the header "
                              "reference,test[,name], paths relative to its folder",
                              request.pairs);
  add_masks(command, request.comparison);
  add_photographs(command, request.comparison);
  add_flip(command, request.comparison.flip);
  add_changes(command, request);
  add_verdict(command, request);
  add_answers(command, request);
  add_threads(command, request.threads);
  add_verbosity(command, request.verbosity);
}

bool is_batch(const CompareRequest& request) {
  std::error_code error;
  return !request.pairs.empty() || fs::is_directory(request.reference, error) ||
         fs::is_directory(request.test, error);
}

void check_request(const CompareRequest& request) {
  check_words(request);
  if (is_batch(request)) {
    check_batch_options(request);
  } else {
    check_pair_options(request);
  }
  const fs::path inputs[] = {request.reference,
                             request.test,
                             request.pairs,
                             request.comparison.mask,
                             request.reference_points.cloud,
                             request.test_points.cloud};
  check_outputs(outputs_of(request), request.overwrite, inputs);
}

void check_pairs(const CompareRequest& request, const std::vector<compare::ImagePair>& pairs) {
  std::vector<fs::path> inputs;
  for (const compare::ImagePair& pair : pairs) inputs.insert(inputs.end(), {pair.reference, pair.test});
  check_outputs(outputs_of(request), request.overwrite, inputs);
}

}  // namespace alidade::tools
