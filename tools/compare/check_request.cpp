// SPDX-License-Identifier: MIT
#include "tools/compare/check_request.h"

#include "base/error.h"

namespace alidade {
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

void check_pairs(const CompareRequest& request, const std::vector<ImagePair>& pairs) {
  std::vector<fs::path> inputs;
  for (const ImagePair& pair : pairs)
    for (const fs::path& file : {pair.reference, pair.test})
      if (!file.empty()) inputs.push_back(file);
  check_outputs(outputs_of(request), request.overwrite, inputs);
}

}  // namespace alidade
