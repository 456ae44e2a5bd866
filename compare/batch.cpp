// SPDX-License-Identifier: MIT
#include "compare/batch.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <set>
#include <tuple>

#include "base/output_file.h"
#include "base/parallel.h"
#include "compare/read_compared_image.h"
#include "compare/report/page.h"
#include "compare/report/report_page.h"

namespace alidade::compare {
namespace {

constexpr std::uint64_t k_most_at_once = 8, k_most_pixels_at_once = std::uint64_t{1} << 25;
constexpr int k_thumbnail_side = 240;

/// Names of the pairs as names of files, each once.
std::vector<std::filesystem::path> report_files(const std::vector<ImagePair>& pairs,
                                                const std::filesystem::path& folder) {
  std::set<std::string> taken;
  std::vector<std::filesystem::path> files;
  for (const ImagePair& pair : pairs) {
    std::string name = pair.name;
    for (char& c : name)
      if (static_cast<unsigned char>(c) < 0x20 || c == '/' || c == '\\' || c == ':') c = '_';
    std::string unique = name;
    for (int number = 2; !taken.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
    files.push_back(folder / (unique + ".html"));
  }
  return files;
}

/// Lets a long task fail before it starts.
void make_room(const std::vector<std::filesystem::path>& reports, const std::vector<ImagePair>& pairs,
               const BatchOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.reports, error);
  if (error)
    throw Error(
        {.file = options.reports.string(), .problem = "cannot create the folder: " + error.message()});
  const auto one_name = [](const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, ignored), ignored);
  };
  std::set<std::filesystem::path> taken;
  for (const std::filesystem::path& file : options.kept) taken.insert(one_name(file));
  for (const ImagePair& pair : pairs) {
    taken.insert(one_name(pair.reference));
    taken.insert(one_name(pair.test));
  }
  for (const std::filesystem::path& report : reports) {
    if (taken.contains(one_name(report)))
      throw Error(report.string(), {}, "exists and is not the report of a pair", "another report folder");
    check_output(report, options.overwrite);
  }
}

/// As many pairs at once as fit into memory.
std::size_t workers_for(const std::vector<ImagePair>& pairs) {
  std::uint64_t workers =
      std::min({k_most_at_once, std::uint64_t{pairs.size()}, std::uint64_t{thread_count()}});
  for (std::size_t i = 0; i < pairs.size() && workers > 1; ++i) {
    for (const std::filesystem::path& file : {pairs[i].reference, pairs[i].test})
      if (const std::uint64_t pixels = claimed_pixels(file); pixels > 0)
        workers = std::min(workers, std::max<std::uint64_t>(1, k_most_pixels_at_once / pixels));
  }
  return workers;
}

void add_thumbnails(PairOutcome& outcome, const ComparisonImages& images) {
  const auto add = [&](const std::string& name, const image::ByteImage& image) {
    outcome.thumbnails.emplace_back(
        name, image::data_url(image::shrunk(image, k_thumbnail_side), image::ImagePacking::jpeg));
  };
  add("reference", images.reference);
  add("test", images.test);
  const std::vector<const DifferenceMap*> maps = images.maps();
  if (maps.empty()) return;
  const DifferenceMap& map = images.flip_map ? *images.flip_map : *maps.front();
  add(map.title, {map.width, map.height, paint_difference(map).bytes()});
}

/// Errors: reports that cannot be written; Cancelled.
void compare_pair(PairOutcome& outcome, const BatchOptions& options, const std::filesystem::path& report,
                  const Progress& progress) {
  const ImagePair& pair = outcome.pair;
  if (pair.reference.empty() || pair.test.empty()) {
    outcome.error = pair.test.empty() ? "the test folder has no image with this name"
                                      : "the reference folder has no image with this name";
    return;
  }
  ComparisonOptions what = options.comparison;
  what.keep_images = options.keep_thumbnails || !options.reports.empty();
  std::string page;
  try {
    outcome.comparison = compare_files(pair.reference, pair.test, what, progress);
    outcome.verdict = judge(*outcome.comparison, options.fail_above);
    outcome.warnings = judge(*outcome.comparison, options.warn_above);
    if (!options.reports.empty())
      page = report_page(*outcome.comparison, outcome.verdict, options.packing, outcome.warnings);
    if (options.keep_thumbnails) add_thumbnails(outcome, *outcome.comparison->images);
  } catch (const Error& error) {
    outcome.error = error.what();
    outcome.sizes_differ = dynamic_cast<const SizeMismatch*>(&error) != nullptr;
    outcome.comparison.reset();
    return;
  } catch (const std::bad_alloc&) {
    outcome.error = "not enough memory";
    outcome.comparison.reset();
    return;
  }
  outcome.comparison->images.reset();
  // Swapped, since an assigned empty list would keep the memory.
  std::vector<std::uint32_t>().swap(outcome.comparison->reference.ids);
  std::vector<std::uint32_t>().swap(outcome.comparison->test.ids);
  if (outcome.comparison->changes) std::vector<std::uint32_t>().swap(outcome.comparison->changes->labels);
  if (page.empty()) return;
  write_text_file(report, page, options.overwrite);
  outcome.report = report;
}

/// Outcomes with smaller keys come first.
auto sort_key(const PairOutcome& outcome) {
  double badness = 0.0;
  if (outcome.comparison) {
    for (const char* const name : {"flip", "depth_mean"}) {
      const std::optional<double> value = find_metric(name)->value(*outcome.comparison);
      if (!value) continue;
      badness = std::isnan(*value) ? std::numeric_limits<double>::infinity() : *value;
      break;
    }
  }
  return std::tuple(outcome.error.empty(), outcome.pass(), -badness);
}

}  // namespace

std::vector<PairOutcome> compare_pairs(const std::vector<ImagePair>& pairs, const BatchOptions& options,
                                       const Progress& progress) {
  std::vector<PairOutcome> outcomes(pairs.size());
  const std::vector<std::filesystem::path> reports = report_files(pairs, options.reports);
  if (!options.reports.empty()) make_room(reports, pairs, options);
  std::atomic<bool> stopped = false;
  std::mutex reporting;
  std::uint64_t done = 0;
  std::chrono::steady_clock::time_point asked{};
  const auto goes_on = [&](bool is_done) {
    constexpr std::chrono::milliseconds k_pause{50};
    const std::lock_guard lock(reporting);
    done += is_done;
    const auto now = std::chrono::steady_clock::now();
    if (stopped || !progress || (!is_done && now - asked < k_pause)) return !stopped;
    asked = now;
    if (!progress(done, pairs.size())) stopped = true;
    return !stopped;
  };
  // Each worker holds one pair in memory, however many threads help with it.
  in_parallel(pairs.size(), 1, workers_for(pairs), [&](std::size_t i) {
    if (stopped) return;
    outcomes[i].pair = pairs[i];
    compare_pair(outcomes[i], options, reports[i],
                 [&](std::uint64_t, std::uint64_t) { return goes_on(false); });
    goes_on(true);
  });
  if (stopped) throw Cancelled();
  std::ranges::stable_sort(outcomes, [](const PairOutcome& a, const PairOutcome& b) {
    return std::tuple_cat(sort_key(a), std::tie(a.pair.name)) <
           std::tuple_cat(sort_key(b), std::tie(b.pair.name));
  });
  return outcomes;
}

}  // namespace alidade::compare
