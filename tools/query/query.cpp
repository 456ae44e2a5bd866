// SPDX-License-Identifier: MIT
#include "tools/query/query.h"

#include <fmt/format.h>
#include <array>

#include "base/error.h"
#include "base/words.h"
#include "tools/command.h"
#include "tools/query/target_kind.h"

namespace alidade::tools {
namespace {

struct FamilyWords {
  const char* texts;  ///< option that takes a file
  const char* value;  ///< option that takes one target, or a part of one
  const TargetKind& (*kind)();
  const char* help;
};

// In the order of TargetFamily.
constexpr std::array<FamilyWords, k_target_families> k_families{{
    {"--rays", "--ray", target_kind<Ray>, "rays: origin, direction of any length"},
    {"--cones", "--cone", target_kind<Cone>,
     "cones: apex, axis, half angle in degrees, radius at the apex (default 0)"},
    {"--path", "--vertex", target_kind<Path>,
     "trajectories: vertices in order; rows with one `path` number form one"},
    {"--planes", "--plane", target_kind<HalfSpaces>,
     "regions: points on the positive side of all planes with one `region` number"},
    {"--boxes", "--box", target_kind<Bounds>, "axis-aligned boxes, faces included"},
    {"--points", "--point", target_kind<glm::dvec3>, "places"},
}};

void add_targets(const Options& query, QueryCommand& command) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const FamilyWords& words = k_families[i];
    GivenTargets& given = command.targets[i];
    query.group("Targets").text(words.texts, "FILE|-", words.help, given.text);
    std::string form = words.kind().form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.group("Targets").text(words.value, form, "one target; repeatable", given.values);
  }
}

void add_conditions(const Options& query, QueryCommand& command) {
  const Options group = query.group("Conditions");
  group.value("--radius", "R", "largest distance from the ray, path or point, in metres (default: inf)",
              command.radius, parse_length_limit);
  group.count("--k", "K",
              "most points per target, in the order of the measure (default: 1 for rays, paths and points "
              "without --radius, else all)",
              command.k, 1, k_all);
  group.choice("--measure",
               "order of points: distance to the ray, position t of the projection, or where the ray enters "
               "the sphere of the radius around the point (default: rays entry with --radius, else distance; "
               "cones distance; paths t)",
               command.measure,
               {{"distance", Measure::distance}, {"t", Measure::t}, {"entry", Measure::entry}});
  group.value("--t-min", "A",
              "points that project to t >= A, metres along the ray, cone or path, if the targets do not set "
              "it (default: -inf; cones 0)",
              command.t_min, parse_limit);
  group.value("--t-max", "B", "points that project to t <= B (default: inf)", command.t_max, parse_limit);
  group.value("--entry-min", "E", "for rays with --radius: spheres entered at E or later, metres",
              command.entry_min, parse_limit);
  group.value("--class", "LIST", "points of these classes, such as 2,6", command.classes, parse_classes);
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
              "memory for points of a COPC file: bytes, or a number with k, M, G or T (default: 512M)",
              command.memory, parse_size);
}

void add_answers(const Options& query, QueryCommand& command) {
  const Options group = query.group("Answers");
  const Option occluded =
      group.flag("--occluded", "only whether any point matches: 0 or 1 per target", command.occluded);
  group.flag("--count", "only the number of matching points, up to K", command.count).excludes(occluded);
  group.file("-o,--output", "FILE", "output file: .csv, .jsonl, .las or .laz (default: CSV to stdout)",
             command.output);
  group.choice("--format", "output format, whatever the extension", command.format,
               {{"csv", AnswerForm::csv}, {"jsonl", AnswerForm::json_lines}, {"las", AnswerForm::las}});
  group.flag("--overwrite", "replace an existing file", command.overwrite);
  group.flag("--explain", "print the cost on stderr: nodes, points, and what each rule pruned",
             command.explain);
}

[[noreturn]] void reject(const char* option, const FamilyWords& words) {
  throw Error({.problem = fmt::format("{} does not apply to {}", option, words.kind().plural)});
}

/// The family that targets were given of. Errors: none, several, or in two ways.
TargetFamily chosen_family(const QueryCommand& command) {
  std::optional<std::size_t> chosen;
  std::string all;
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const GivenTargets& given = command.targets[i];
    all += (all.empty() ? "" : ", ") + std::string(k_families[i].texts);
    const bool has_text = !given.text.empty(), has_values = !given.values.empty();
    if (!has_text && !has_values) continue;
    if (has_text && has_values) {
      throw Error(
          {.problem = fmt::format("{} and {} exclude each other", k_families[i].texts, k_families[i].value),
           .expected = "one of them"});
    }
    if (chosen) {
      throw Error({.problem = fmt::format("{} and {} are different kinds of targets",
                                          k_families[*chosen].kind().plural, k_families[i].kind().plural),
                   .expected = "one kind per run"});
    }
    chosen = i;
  }
  if (!chosen) throw Error({.problem = "missing targets", .expected = "one of " + all});
  return static_cast<TargetFamily>(*chosen);
}

/// Errors: an option was given that does not apply for this family, or without another.
void check_options(const QueryCommand& command) {
  using enum TargetFamily;
  const TargetFamily family = command.family;
  const FamilyWords& words = k_families[static_cast<std::size_t>(family)];
  const bool has_t = family == rays || family == cones || family == path;
  if (command.radius && (family == cones || family == planes || family == boxes)) reject("--radius", words);
  if (command.measure && !has_t) reject("--measure", words);
  if (command.t_min && !has_t) reject("--t-min", words);
  if (command.t_max && !has_t) reject("--t-max", words);
  if (command.entry_min && family != rays) reject("--entry-min", words);
  if (command.entry_min && !command.radius)
    throw Error({.problem = "--entry-min requires a radius", .expected = "--radius R"});
  if (command.measure == Measure::entry && family == rays && !command.radius)
    throw Error({.problem = "--measure entry requires a radius", .expected = "--radius R"});
  if (command.measure == Measure::entry && family == path)
    throw Error({.problem = "--measure entry does not apply to paths", .expected = "t or distance"});
}

ExitCode run(const QueryCommand& given) {
  QueryCommand command = given;
  command.family = chosen_family(command);
  check_options(command);
  return run_query(command);
}

}  // namespace

LineSource open_targets(const QueryCommand& command) {
  const GivenTargets& given = command.given();
  return given.text.empty() ? LineSource::command_line(
                                  k_families[static_cast<std::size_t>(command.family)].value, given.values)
                            : LineSource::open(given.text);
}

AnswerForm chosen_form(const QueryCommand& command) {
  const std::string extension = file_extension(command.output);
  std::optional<AnswerForm> form = command.format;
  if (!form && command.output.empty()) form = AnswerForm::csv;
  if (!form && extension == ".csv") form = AnswerForm::csv;
  if (!form && (extension == ".jsonl" || extension == ".ndjson")) form = AnswerForm::json_lines;
  if (!form && (extension == ".las" || extension == ".laz")) form = AnswerForm::las;
  if (!form)
    throw file_error(command.output, "unknown output format", ".csv, .jsonl, .las or .laz, or --format");
  if (form == AnswerForm::las && command.output.empty())
    throw Error({.problem = "LAS output requires a file", .expected = "-o FILE.las"});
  if (form == AnswerForm::las && (command.count || command.occluded))
    throw file_error(command.output, "LAS cannot store --count and --occluded", ".csv or .jsonl");
  return *form;
}

Command add_query(const Options& program) {
  const Options query = program.command(
      "query", "Find the points near rays, paths and positions, and in cones, planes and boxes");
  auto command = std::make_shared<QueryCommand>();
  add_cloud(query, *command);
  add_targets(query, *command);
  add_conditions(query, *command);
  add_answers(query, *command);
  add_copc(query, *command);
  add_run_options(query, *command);
  return command_of(query, command, run);
}

}  // namespace alidade::tools
