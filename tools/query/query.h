// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octree/query.h"
#include "tools/console.h"
#include "tools/options.h"
#include "tools/query/line_source.h"

namespace alidade::tools {

/// The families of targets; a run asks with one of them.
enum class TargetFamily { rays, cones, path, planes, boxes, points };
constexpr std::size_t k_target_families = 6;

/// How targets of one family were given: by the name of a text, or one by one.
struct GivenTargets {
  std::string text;  ///< "-" is standard input; empty if none was given
  std::vector<std::string> values;
  std::string text_option, value_option;  ///< "--rays", "--ray"
};

enum class AnswerForm { csv, json_lines, las };

/// What was asked of `alidade query`.
struct QueryCommand : CloudRequest {
  GivenTargets targets[k_target_families];
  std::optional<double> radius, t_min, t_max, entry_min;
  std::optional<std::size_t> k;
  std::optional<Measure> measure;
  std::optional<int> max_level;
  std::optional<std::bitset<256>> classes;
  bool occluded = false, count = false, explain = false;
  bool is_loaded = false;             ///< a COPC file is not asked where it lies
  std::optional<std::size_t> memory;  ///< bytes to keep of a COPC file that is
  std::filesystem::path output;
  std::optional<AnswerForm> format;
  bool overwrite = false;
};

/// Declares the command's options; they fill what is returned.
std::shared_ptr<QueryCommand> add_query_options(const Options& query);

/// The family that targets were given of. Errors: none, several, or in two ways.
TargetFamily chosen_family(const QueryCommand& command);

/// The text the targets stand in. Errors: LineSource::open().
LineSource open_targets(const QueryCommand& command, TargetFamily family);

/// The form of the output: as asked for, else by the ending of its name; csv for stdout. Errors: neither
/// tells; las without a file, or for numbers only.
AnswerForm chosen_form(const QueryCommand& command);

/// Errors: an option was given that means nothing for this family, or without another.
void check_options(const QueryCommand& command, TargetFamily family);

/// Does what was asked: reads targets, asks the octree batch by batch in parallel, writes. Memory beside
/// cloud and octree: about 200 MB at most, whatever the number of targets and answers; a single target with
/// more than a million answers takes what these take; if work is explained, some dozens of them. Errors: of
/// options that do not go together, of cloud, targets and output.
template <class Target>
ExitCode run_query(const QueryCommand& command, TargetFamily family);

extern template ExitCode run_query<Ray>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Cone>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Path>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<HalfSpaces>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Bounds>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<glm::dvec3>(const QueryCommand& command, TargetFamily family);

}  // namespace alidade::tools
