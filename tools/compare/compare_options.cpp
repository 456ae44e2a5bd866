// SPDX-License-Identifier: MIT
#include "tools/compare/compare_options.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;

/// "LEFT,TOP,RIGHT,BOTTOM" in pixels.
compare::PixelRectangle parse_rectangle(const std::string& text) {
  constexpr std::uint64_t k_farthest = 1 << 20;
  std::array<int, 4> numbers{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const bool is_last = i == 3;
    if ((end == text.size()) != is_last)
      throw UsageError("expected LEFT,TOP,RIGHT,BOTTOM in pixels, as 0,0,600,400, found '" + text + "'");
    numbers[i] = static_cast<int>(parse_count(text.substr(begin, end - begin), 0, k_farthest));
    begin = end + 1;
  }
  const compare::PixelRectangle rectangle{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom)
    throw UsageError("expected LEFT < RIGHT and TOP < BOTTOM, found '" + text + "'");
  return rectangle;
}

/// An option that may be repeated; all its thresholds hold.
void add_thresholds(const Options& group, const std::string& name, const std::string& help,
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

void add_rectangles(const Options& group, const std::string& name, const std::string& help,
                    std::vector<compare::PixelRectangle>& rectangles) {
  group.values(name, "L,T,R,B", help,
               [&rectangles](const std::string& text) { rectangles.push_back(parse_rectangle(text)); });
}

void add_what_counts(const Options& command, compare::ComparisonOptions& options) {
  const Options group = command.group("What counts");
  group.value("--crop", "L,T,R,B",
              "compare only this part of both pictures: columns L to R - 1 and rows T to B - 1, in pixels "
              "from the top left",
              options.crop, parse_rectangle);
  group.choice("--resize",
               "of pictures of different size: none is an error (default), reference resizes the test",
               options.resize_to_reference, {{"none", false}, {"reference", true}});
  group.file("--mask", "FILE", "picture of the reference's size; only pixels that are light in it count",
             options.mask);
  add_rectangles(group, "--only", "only pixels in this rectangle count. May be repeated", options.keep);
  add_rectangles(group, "--ignore", "pixels in this rectangle do not count. May be repeated", options.ignore);
  group.flag("--opaque",
             "only pixels with an alpha of at least one half count, in every picture that has alpha",
             options.use_alpha);
  group.flag("--valid-depth", "only pixels with finite depth above 0 count, in every picture that has depth",
             options.valid_depth);
  group.flag("--ignore-sky", "pixels in which both see no surface do not count", options.ignore_sky);
}

void add_photographs(const Options& command, compare::ComparisonOptions& options) {
  const Options group = command.group("Photographs");
  group.choice(
      "--match",
      "fit the colours of the test to the reference, and tell the figures again with matched colours: "
      "exposure is a factor per channel (exposure, white balance), affine an offset too (haze, black level)",
      options.match, {{"exposure", compare::ColorModel::exposure}, {"affine", compare::ColorModel::affine}});
  const Option align = group.flag("--align",
                                  "look for the shift at which the edges of both fit best, which tells a "
                                  "camera that is off from colours that differ",
                                  options.align);
  group
      .count("--largest-shift", "PIXELS", "up to which --align looks (default: 64)", options.largest_shift, 1,
             4096)
      .needs(align);
}

void add_flip(const Options& command, compare::FlipOptions& flip) {
  const Options group = command.group("FLIP");
  group.number(
      "--pixels-per-degree", "N",
      "of the eye's field of view (default: 67.02: a screen 0.7 m wide with 3840 pixels, seen from 0.7 m)",
      flip.pixels_per_degree, 1.0, 1000.0);
  group.choice("--tone-mapper", "of linear light (default: aces)", flip.tone_mapper,
               {{"aces", compare::ToneMapper::aces},
                {"hable", compare::ToneMapper::hable},
                {"reinhard", compare::ToneMapper::reinhard}});
  const auto add_exposure = [&](const char* name, const char* help, std::optional<double>& exposure) {
    group.number(name, "STOPS", help, exposure, -1000.0, 1000.0);
  };
  add_exposure("--start-exposure", "the darkest exposure of linear light (default: found from the reference)",
               flip.start_exposure);
  add_exposure("--stop-exposure", "the brightest one (default: found from the reference)",
               flip.stop_exposure);
  group.count("--exposures", "N", "how many from the one to the other (default: one per stop)",
              flip.exposures, 2, 256);
}

void add_changes(const Options& command, CompareRequest& request) {
  const Options group = command.group("Where it changed");
  compare::ComparisonOptions& options = request.comparison;
  const Option changes = group.choice("--changes",
                                      "list regions of changed pixels by size: by FLIP, by the difference of "
                                      "colours (0 to 1), or of depth (metres)",
                                      options.find_changes,
                                      {{"flip", compare::ChangeMap::flip},
                                       {"color", compare::ChangeMap::color},
                                       {"depth", compare::ChangeMap::depth}});
  group
      .number("--change-threshold", "VALUE", "pixels above it have changed (default: 0.2)",
              options.changes.threshold, 0.0, 1e9)
      .needs(changes);
  group
      .count("--least-pixels", "N", "regions of fewer changed pixels are left out (default: 16)",
             options.changes.least_pixels, 1, 1'000'000'000)
      .needs(changes);
  group.file("--reference-points", "FILE.las|FILE.laz",
             "points that the regions show in the reference, of --reference-cloud; needs the layer id",
             request.reference_points.output);
  group.file("--reference-cloud", "CLOUD", "the cloud that the reference was made of",
             request.reference_points.cloud);
  group.file("--test-points", "FILE.las|FILE.laz",
             "points that the regions show in the test, of --test-cloud", request.test_points.output);
  group.file("--test-cloud", "CLOUD", "the cloud that the test was made of", request.test_points.cloud);
  group.flag("--partial", "read what is whole of damaged clouds, as the pictures were made with --partial",
             request.partial);
}

void add_verdict(const Options& command, CompareRequest& request) {
  const Options group = command.group("Verdict");
  add_thresholds(group, "--fail-above",
                 "thresholds beyond which the answer is no, as flip=0.05,psnr<30: NAME=LIMIT fails what is "
                 "worse, NAME<LIMIT what is below, NAME>LIMIT what is above. May be repeated",
                 request.fail_above);
  add_thresholds(group, "--warn-above",
                 "thresholds beyond which a warning is given, in the same form. May be repeated",
                 request.warn_above);
  group.flag("--idiff-codes",
             "end as OpenImageIO's idiff: 0 pass, 1 warning, 2 beyond a threshold, 3 sizes differ, 4 "
             "anything else wrong; wrong options are 2 nevertheless",
             request.idiff_codes);
}

void add_answers(const Options& command, CompareRequest& request) {
  const Options group = command.group("Answers");
  group.flag("--json", "print the result as JSON instead of a table", request.json);
  group.file("--report", "FILE.html",
             "a page for people, in one file that needs no network: pictures to swipe and blink, maps, "
             "regions, figures; of many pairs a summary",
             request.report);
  group.file("--reports", "FOLDER", "of many pairs: a page for each, in this folder", request.reports);
  group.choice(
      "--report-pictures",
      "how pages hold pictures: without loss or at a fifth of the size (default: png up to 2 million pixels)",
      request.packing, {{"png", image::PicturePacking::png}, {"jpeg", image::PicturePacking::jpeg}});
  group.file("--color-map", "FILE.png", "picture of the differences of colour, with legend",
             request.color_map);
  group.file("--flip-map", "FILE.png", "picture of FLIP, with legend", request.flip_map);
  group.file("--depth-map", "FILE.png", "picture of the differences of depth, with legend",
             request.depth_map);
  group.flag("--overwrite", "replace existing files", request.overwrite);
}

/// Files that the run writes, all of them.
std::vector<std::filesystem::path> outputs_of(const CompareRequest& request) {
  return {request.report,
          request.color_map,
          request.flip_map,
          request.depth_map,
          request.reference_points.output,
          request.test_points.output};
}

void require(bool holds, const char* problem, const char* expected) {
  if (!holds) throw Error({.problem = problem, .expected = expected});
}

void check_words(const CompareRequest& request) {
  if (request.pairs.empty()) {
    require(!request.reference.empty() && !request.test.empty(), "nothing to compare",
            "REFERENCE and TEST, or --pairs FILE.csv");
  } else {
    require(request.reference.empty(), "pictures are named, and a table of pairs as well",
            "REFERENCE and TEST, or --pairs FILE.csv");
  }
}

void check_wishes_for_many(const CompareRequest& request) {
  const bool has_clouds = !request.reference_points.cloud.empty() || !request.test_points.cloud.empty();
  require(!request.has_maps() && !request.has_points() && !has_clouds,
          "maps and points are written for one pair of pictures", "--report or --reports for many");
  require(!request.packing || !request.reports.empty(), "--report-pictures is for the pages of pairs",
          "--reports FOLDER beside it");
}

void check_wishes_for_one(const CompareRequest& request) {
  require(request.reports.empty(), "--reports is for many pairs", "--report FILE.html");
  require(!request.packing || !request.report.empty(), "--report-pictures is for pages",
          "--report FILE.html beside it");
  require(!request.has_points() || request.comparison.find_changes,
          "points are those behind regions of change",
          "--changes flip|color|depth beside --reference-points or --test-points");
  for (const RegionPointsRequest& points : {request.reference_points, request.test_points})
    require(points.cloud.empty() == points.output.empty(),
            "points behind regions need both their cloud and their file",
            "--reference-cloud with --reference-points, --test-cloud with --test-points");
}

}  // namespace

void add_compare_options(const Options& command, CompareRequest& request) {
  command.file("reference", "REFERENCE", "picture, or folder of pictures, that is right", request.reference);
  command.file("test", "TEST", "picture, or folder of pictures, that is judged", request.test);
  command.group("Pairs").file("--pairs", "FILE.csv",
                              "pairs of pictures, instead of REFERENCE and TEST: a table with the header "
                              "reference,test[,name], paths from its folder on",
                              request.pairs);
  add_what_counts(command, request.comparison);
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
    check_wishes_for_many(request);
  } else {
    check_wishes_for_one(request);
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
