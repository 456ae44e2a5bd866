// SPDX-License-Identifier: MIT
#include "tools/compare/compare_options.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include "base/error.h"

namespace alidade::tools {
namespace {

constexpr std::array<std::pair<std::string_view, compare::ToneMapper>, 3> k_tone_mappers = {
    {{"aces", compare::ToneMapper::aces},
     {"hable", compare::ToneMapper::hable},
     {"reinhard", compare::ToneMapper::reinhard}}};

/// "LEFT,TOP,RIGHT,BOTTOM" in pixels.
compare::PixelRectangle parse_rectangle(const std::string& text) {
  constexpr std::uint64_t k_farthest = 1 << 20;
  std::array<int, 4> numbers{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const bool is_last = i == 3;
    if ((end == text.size()) != is_last)
      throw CLI::ValidationError("expected LEFT,TOP,RIGHT,BOTTOM in pixels, as 0,0,600,400, found '" + text +
                                 "'");
    numbers[i] = static_cast<int>(parse_count(text.substr(begin, end - begin), 0, k_farthest));
    begin = end + 1;
  }
  const compare::PixelRectangle rectangle{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom)
    throw CLI::ValidationError("expected LEFT < RIGHT and TOP < BOTTOM, found '" + text + "'");
  return rectangle;
}

/// An option that may be repeated; all its thresholds hold.
void add_thresholds(CLI::App& command, const std::string& name, const std::string& help,
                    std::vector<compare::Threshold>& thresholds, const char* group) {
  const auto take = [name, &thresholds](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      try {
        const std::vector<compare::Threshold> more = compare::parse_thresholds(text);
        thresholds.insert(thresholds.end(), more.begin(), more.end());
      } catch (const Error& error) {
        throw CLI::ValidationError(name, error.what());
      }
    }
  };
  command.add_option_function<std::vector<std::string>>(name, take, help)
      ->option_text("LIST")
      ->allow_extra_args(false)
      ->group(group);
}

void add_file(CLI::App& command, const std::string& name, const std::string& kind, const std::string& help,
              std::filesystem::path& target, const char* group) {
  command.add_option(name, target, help)->option_text(kind)->group(group);
}

void add_rectangles(CLI::App& command, const std::string& name, const std::string& help,
                    std::vector<compare::PixelRectangle>& rectangles, const char* group) {
  command
      .add_option_function<std::vector<std::string>>(
          name,
          [name, &rectangles](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              try {
                rectangles.push_back(parse_rectangle(text));
              } catch (const CLI::ValidationError& error) {
                throw CLI::ValidationError(name, error.what());
              }
            }
          },
          help)
      ->option_text("L,T,R,B")
      ->allow_extra_args(false)
      ->group(group);
}

void add_what_counts(CLI::App& command, compare::ComparisonOptions& options) {
  const char* const group = "What counts";
  add_value(command, "--crop", "L,T,R,B",
            "compare only this part of both pictures: columns L to R - 1 and rows T to B - 1, in pixels from "
            "the top left",
            [&options](const std::string& text) { options.crop = parse_rectangle(text); })
      ->group(group);
  add_value(command, "--resize", "none|reference",
            "of pictures of different size: none is an error (default), reference resizes the test",
            [&options](const std::string& text) {
              if (text != "none" && text != "reference")
                throw CLI::ValidationError("expected none|reference, found '" + text + "'");
              options.resize_to_reference = text == "reference";
            })
      ->group(group);
  add_file(command, "--mask", "FILE",
           "picture of the reference's size; only pixels that are light in it count", options.mask, group);
  add_rectangles(command, "--only", "only pixels in this rectangle count. May be repeated", options.keep,
                 group);
  add_rectangles(command, "--ignore", "pixels in this rectangle do not count. May be repeated",
                 options.ignore, group);
  command
      .add_flag("--opaque", options.use_alpha,
                "only pixels with an alpha of at least one half count, in every picture that has alpha")
      ->group(group);
  command
      .add_flag("--valid-depth", options.valid_depth,
                "only pixels with finite depth above 0 count, in every picture that has depth")
      ->group(group);
  command.add_flag("--ignore-sky", options.ignore_sky, "pixels in which both see no surface do not count")
      ->group(group);
}

void add_photographs(CLI::App& command, compare::ComparisonOptions& options) {
  const char* const group = "Photographs";
  add_choice(command, "--match",
             "fit the colours of the test to the reference, and tell the figures again with matched colours: "
             "exposure is "
             "a factor per channel (exposure, white balance), affine an offset too (haze, black level)",
             options.match,
             {{"exposure", compare::ColorModel::exposure}, {"affine", compare::ColorModel::affine}})
      ->group(group);
  CLI::Option* const align =
      command
          .add_flag(
              "--align", options.align,
              "look for the shift at which the edges of both fit best, which tells a camera that is off "
              "from colours that "
              "differ")
          ->group(group);
  add_value(command, "--largest-shift", "PIXELS", "up to which --align looks (default: 64)",
            [&options](const std::string& text) {
              options.largest_shift = static_cast<int>(parse_count(text, 1, 4096));
            })
      ->needs(align)
      ->group(group);
}

void add_flip(CLI::App& command, compare::FlipOptions& flip) {
  const char* const group = "FLIP";
  add_value(
      command, "--pixels-per-degree", "N",
      "of the eye's field of view (default: 67.02: a screen 0.7 m wide with 3840 pixels, seen from 0.7 m)",
      [&flip](const std::string& text) { flip.pixels_per_degree = parse_number(text, 1.0, 1000.0); })
      ->group(group);
  add_value(command, "--tone-mapper", "aces|hable|reinhard", "of linear light (default: aces)",
            [&flip](const std::string& text) {
              const auto found = std::ranges::find(k_tone_mappers, text,
                                                   &std::pair<std::string_view, compare::ToneMapper>::first);
              if (found == k_tone_mappers.end())
                throw CLI::ValidationError("expected aces|hable|reinhard, found '" + text + "'");
              flip.tone_mapper = found->second;
            })
      ->group(group);
  const auto add_exposure = [&](const char* name, const char* help, std::optional<double>& exposure) {
    add_value(command, name, "STOPS", help, [&exposure](const std::string& text) {
      exposure = parse_number(text, -1000.0, 1000.0);
    })->group(group);
  };
  add_exposure("--start-exposure", "the darkest exposure of linear light (default: found from the reference)",
               flip.start_exposure);
  add_exposure("--stop-exposure", "the brightest one (default: found from the reference)",
               flip.stop_exposure);
  add_value(
      command, "--exposures", "N", "how many from the one to the other (default: one per stop)",
      [&flip](const std::string& text) { flip.exposures = static_cast<int>(parse_count(text, 2, 256)); })
      ->group(group);
}

void add_changes(CLI::App& command, CompareRequest& request) {
  const char* const group = "Where it changed";
  compare::ComparisonOptions& options = request.comparison;
  CLI::Option* const changes = add_choice(
      command, "--changes",
      "list regions of changed pixels by size: by FLIP, by the difference of colours (0 to 1), or of "
      "depth (metres)",
      options.find_changes,
      {{"flip", compare::ChangeMap::flip},
       {"color", compare::ChangeMap::color},
       {"depth", compare::ChangeMap::depth}});
  changes->group(group);
  add_value(command, "--change-threshold", "VALUE", "pixels above it have changed (default: 0.2)",
            [&options](const std::string& text) { options.changes.threshold = parse_number(text, 0.0, 1e9); })
      ->needs(changes)
      ->group(group);
  add_value(command, "--least-pixels", "N", "regions of fewer changed pixels are left out (default: 16)",
            [&options](const std::string& text) {
              options.changes.least_pixels = parse_count(text, 1, 1'000'000'000);
            })
      ->needs(changes)
      ->group(group);
  add_file(command, "--reference-points", "FILE.las|FILE.laz",
           "points that the regions show in the reference, of --reference-cloud; needs the layer id",
           request.reference_points.output, group);
  add_file(command, "--reference-cloud", "CLOUD", "the cloud that the reference was made of",
           request.reference_points.cloud, group);
  add_file(command, "--test-points", "FILE.las|FILE.laz",
           "points that the regions show in the test, of --test-cloud", request.test_points.output, group);
  add_file(command, "--test-cloud", "CLOUD", "the cloud that the test was made of", request.test_points.cloud,
           group);
  command
      .add_flag_function(
          "--partial",
          [&request](std::int64_t) { request.reference_points.partial = request.test_points.partial = true; },
          "read what is whole of damaged clouds, as the pictures were made with --partial")
      ->option_text(" ")
      ->group(group);
}

void add_verdict(CLI::App& command, CompareRequest& request) {
  const char* const group = "Verdict";
  add_thresholds(command, "--fail-above",
                 "thresholds beyond which the answer is no, as flip=0.05,psnr<30: NAME=LIMIT fails what is "
                 "worse, NAME<LIMIT what is below, NAME>LIMIT what is above. May be repeated",
                 request.fail_above, group);
  add_thresholds(command, "--warn-above",
                 "thresholds beyond which a warning is given, in the same form. May be repeated",
                 request.warn_above, group);
  command
      .add_flag("--idiff-codes", request.idiff_codes,
                "end as OpenImageIO's idiff: 0 pass, 1 warning, 2 beyond a threshold, 3 sizes differ, 4 "
                "anything else wrong; wrong options are 2 nevertheless")
      ->group(group);
}

void add_answers(CLI::App& command, CompareRequest& request) {
  const char* const group = "Answers";
  command.add_flag("--json", request.json, "print the result as JSON instead of a table")->group(group);
  add_file(command, "--report", "FILE.html",
           "a page for people, in one file that needs no network: pictures to swipe and blink, maps, "
           "regions, figures; of "
           "many pairs a summary",
           request.report, group);
  add_file(command, "--reports", "FOLDER", "of many pairs: a page for each, in this folder", request.reports,
           group);
  add_choice(
      command, "--report-pictures",
      "how pages hold pictures: without loss or at a fifth of the size (default: png up to 2 million pixels)",
      request.packing, {{"png", image::PicturePacking::png}, {"jpeg", image::PicturePacking::jpeg}})
      ->group(group);
  add_file(command, "--color-map", "FILE.png", "picture of the differences of colour, with legend",
           request.color_map, group);
  add_file(command, "--flip-map", "FILE.png", "picture of FLIP, with legend", request.flip_map, group);
  add_file(command, "--depth-map", "FILE.png", "picture of the differences of depth, with legend",
           request.depth_map, group);
  command.add_flag("--overwrite", request.overwrite, "replace existing files")->group(group);
}

}  // namespace

void add_compare_options(CLI::App& command, CompareRequest& request) {
  command.add_option("reference", request.reference, "picture, or folder of pictures, that is right")
      ->option_text("REFERENCE");
  command.add_option("test", request.test, "picture, or folder of pictures, that is judged")
      ->option_text("TEST");
  add_file(command, "--pairs", "FILE.csv",
           "pairs of pictures, instead of REFERENCE and TEST: a table with the header reference,test[,name], "
           "paths from its "
           "folder on",
           request.pairs, "Pairs");
  add_what_counts(command, request.comparison);
  add_photographs(command, request.comparison);
  add_flip(command, request.comparison.flip);
  add_changes(command, request);
  add_verdict(command, request);
  add_answers(command, request);
  add_threads(command, request.threads);
  add_verbosity(command, request.verbosity);
}

std::vector<std::filesystem::path> outputs_of(const CompareRequest& request) {
  std::vector<std::filesystem::path> outputs;
  for (const std::filesystem::path& output :
       {request.report, request.color_map, request.flip_map, request.depth_map,
        request.reference_points.output, request.test_points.output})
    if (!output.empty()) outputs.push_back(output);
  return outputs;
}

namespace {

namespace fs = std::filesystem;

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
  std::vector<fs::path> inputs;
  for (const fs::path& input : {request.reference, request.test, request.pairs, request.comparison.mask,
                                request.reference_points.cloud, request.test_points.cloud})
    if (!input.empty()) inputs.push_back(input);
  check_outputs(outputs_of(request), request.overwrite, inputs);
}

void check_pairs(const CompareRequest& request, const std::vector<compare::ImagePair>& pairs) {
  std::vector<fs::path> inputs;
  for (const compare::ImagePair& pair : pairs)
    for (const fs::path& file : {pair.reference, pair.test})
      if (!file.empty()) inputs.push_back(file);
  check_outputs(outputs_of(request), request.overwrite, inputs);
}

}  // namespace alidade::tools
