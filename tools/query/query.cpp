// SPDX-License-Identifier: MIT
#include "tools/query/query.h"

#include <fmt/format.h>

#include "base/words.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

void add_targets(const Options& query, QueryCommand& command) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const TargetKind& kind = target_kind(static_cast<TargetFamily>(i));
    GivenTargets& given = command.targets[i];
    query.group("Targets").text(kind.texts_option, "FILE|-", kind.help, given.text);
    std::string form = kind.form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.group("Targets").text(kind.value_option, form, "one target; repeatable", given.values);
  }
}

void add_conditions(const Options& query, QueryCommand& command) {
  const Options group = query.group("Conditions");
  group.value("--radius", "R", "largest distance from the ray, path or point, in metres (default: inf)",
              command.radius, parse_length_limit);
  group.count("--k", "K",
              "most points per target, in the order of the measure (default: 1 for rays, lines, paths and "
              "points without --radius, else all)",
              command.k, 1, k_all);
  group.choice("--measure",
               "order of points: distance to the ray, position t of the projection, or where the ray enters "
               "the sphere of the radius around the point (default: rays and lines entry with --radius, else "
               "distance; cones distance; paths t)",
               command.measure,
               {{"distance", Measure::distance}, {"t", Measure::t}, {"entry", Measure::entry}});
  group.value(
      "--t-min", "A",
      "points that project to t >= A, metres along the ray, line, cone or path, if the targets do not "
      "set it (default: rays and cones 0, lines and paths -inf)",
      command.t_min, parse_limit);
  group.value("--t-max", "B", "points that project to t <= B (default: inf)", command.t_max, parse_limit);
  group.value("--entry-min", "E", "for rays and lines with --radius: spheres entered at E or later, metres",
              command.entry_min, parse_limit);
  group.value("--classes,--class", "LIST",
              "points of these classes, such as 2,6; point ids stay those of all points", command.classes,
              parse_classes);
  group.count("--max-level", "N",
              "a thinned cloud: levels 0 to N of a layered octree; built for cloud files, while an index "
              "file must be layered (alidade index --organisation layered)",
              command.max_level, 0, k_all_levels);
}

void add_copc(const Options& query, QueryCommand& command) {
  const Options group = query.group("COPC");
  group.flag("--load",
             "read the whole cloud and build an octree, also for a COPC file, which is otherwise queried in "
             "place; faster from some thousands of targets on, more for larger files",
             command.is_loaded);
  group.value("--memory", "SIZE",
              "memory for points of COPC files: bytes, or a number with k, M, G or T (default: 512M)",
              command.memory, parse_size);
}

void add_answers(const Options& query, QueryCommand& command) {
  const Options group = query.group("Answers");
  const Option occluded =
      group.flag("--occluded", "only whether any point matches: 0 or 1 per target", command.occluded);
  group.excludes(occluded).flag("--count", "only the number of matching points, up to K", command.count);
  group.count(
      "--precision", "N",
      "significant digits of all numbers in CSV and JSON, 1 to 17 (default: coordinates have the decimals of "
      "the cloud, other numbers as many as give the same number again)",
      command.precision, 1, 17);
  group.file("-o,--output", "FILE", "output file: .csv, .jsonl, .las or .laz (default: CSV to stdout)",
             command.output);
  group.choice("--format", "output format, whatever the extension", command.format,
               {{"csv", AnswerForm::csv}, {"jsonl", AnswerForm::json_lines}, {"las", AnswerForm::las}});
  group.flag("--overwrite", "replace an existing file", command.overwrite);
  group.flag("--explain", "print the cost on stderr: nodes, points, and what each rule pruned",
             command.explain);
}

[[noreturn]] void reject(const char* option, TargetFamily family) {
  throw Error({.problem = fmt::format("{} does not apply to {}", option, target_kind(family).plural)});
}

/// The family of the given targets. Errors: no targets, several families, or one given in two ways.
TargetFamily chosen_family(const QueryCommand& command) {
  std::optional<TargetFamily> chosen;
  std::string all;
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const GivenTargets& given = command.targets[i];
    const TargetKind& kind = target_kind(static_cast<TargetFamily>(i));
    all += (all.empty() ? "" : ", ") + std::string(kind.texts_option);
    const bool has_text = !given.text.empty(), has_values = !given.values.empty();
    if (!has_text && !has_values) continue;
    if (has_text && has_values) {
      throw input_error(fmt::format("{} and {} exclude each other", kind.texts_option, kind.value_option),
                        "one of them");
    }
    if (chosen) {
      throw input_error(
          fmt::format("{} and {} are different kinds of targets", target_kind(*chosen).plural, kind.plural),
          "one kind per run");
    }
    chosen = static_cast<TargetFamily>(i);
  }
  if (!chosen) throw input_error("missing targets", "one of " + all);
  return *chosen;
}

/// Errors: an option does not apply to this family, or requires another.
void check_options(const QueryCommand& command) {
  using enum TargetFamily;
  const TargetFamily family = command.family;
  const bool is_straight = family == rays || family == lines;
  const bool has_t = is_straight || family == cones || family == path;
  if (command.radius && (family == cones || family == planes || family == boxes)) reject("--radius", family);
  if (command.measure && !has_t) reject("--measure", family);
  if (command.t_min && !has_t) reject("--t-min", family);
  if (command.t_max && !has_t) reject("--t-max", family);
  if (command.entry_min && !is_straight) reject("--entry-min", family);
  if (command.entry_min && !command.radius) throw input_error("--entry-min requires a radius", "--radius R");
  if (command.measure == Measure::entry && is_straight && !command.radius)
    throw input_error("--measure entry requires a radius", "--radius R");
  if (command.measure == Measure::entry && family == path)
    throw input_error("--measure entry does not apply to paths", "t or distance");
}

ExitCode run(const QueryCommand& given) {
  QueryCommand command = given;
  command.family = chosen_family(command);
  check_options(command);
  // The library's rays are whole lines, as the paper's.
  if (command.family == TargetFamily::rays && !command.t_min) command.t_min = 0.0;
  return run_query(command);
}

}  // namespace

LineSource open_targets(const QueryCommand& command) {
  const GivenTargets& given = command.given();
  if (!given.text.empty()) return LineSource::open(given.text);
  return LineSource::command_line(target_kind(command.family).value_option, given.values);
}

AnswerForm chosen_form(const QueryCommand& command) {
  const std::string extension = file_extension(command.output);
  std::optional<AnswerForm> form = command.format;
  if (!form && command.output.empty()) form = AnswerForm::csv;
  if (!form && extension == ".csv") form = AnswerForm::csv;
  if (!form && (extension == ".jsonl" || extension == ".ndjson")) form = AnswerForm::json_lines;
  if (!form && (extension == ".las" || extension == ".laz")) form = AnswerForm::las;
  if (!form)
    throw file_error(command.output, "unknown output format",
                     "the extension .csv, .jsonl, .las or .laz, or --format");
  if (form == AnswerForm::las && command.output.empty())
    throw input_error("LAS output requires a file", "-o FILE.las");
  if (form == AnswerForm::las && (command.count || command.occluded))
    throw file_error(command.output, "LAS cannot store --count and --occluded",
                     "the extension .csv or .jsonl");
  return *form;
}

Command add_query(const Options& program) {
  const Options query = program.command(
      "query", "Find the points near rays, paths and positions, and in cones, planes and boxes");
  auto command = std::make_shared<QueryCommand>();
  add_cloud(query, *command, {"--classes"});
  add_targets(query, *command);
  add_conditions(query, *command);
  add_answers(query, *command);
  add_copc(query, *command);
  add_run_options(query, *command);
  return command_of(query, command, run);
}

}  // namespace alidade::tools
