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
     "trajectories: vertices in their order; rows of one `path` number are one"},
    {"--planes", "--plane", target_kind<HalfSpaces>,
     "regions: points on the side the normal shows to, of all planes with one `region` number"},
    {"--boxes", "--box", target_kind<Bounds>, "axis-parallel boxes, faces included"},
    {"--points", "--point", target_kind<glm::dvec3>, "places"},
}};

void add_targets(const Options& query, QueryCommand& command) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const FamilyWords& words = k_families[i];
    GivenTargets& given = command.targets[i];
    query.group("Targets").text(words.texts, "FILE|-", words.help, given.text);
    std::string form = words.kind().form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.group("Targets").text(words.value, form, "one of them; may be repeated", given.values);
  }
}

void add_conditions(const Options& query, QueryCommand& command) {
  const Options group = query.group("Conditions");
  group.value("--radius", "R", "points at most so far from the ray, path or point, in metres (default: inf)",
              command.radius, parse_length_limit);
  group.count("--k", "K",
              "at most so many points, the first by the measure (default: 1 for rays, paths and points "
              "without --radius, else all)",
              command.k, 1, k_all);
  group.choice("--measure",
               "what puts points into order: distance to the ray, place t of the projection, or where the "
               "ray enters the sphere of the radius around the point (default: rays entry with --radius, "
               "else distance; cones distance; paths t)",
               command.measure,
               {{"distance", Measure::distance}, {"t", Measure::t}, {"entry", Measure::entry}});
  group.value("--t-min", "A",
              "points that project to t >= A, metres along the ray, cone or path, where the targets do not "
              "say it themselves (default: -inf; cones 0)",
              command.t_min, parse_limit);
  group.value("--t-max", "B", "points that project to t <= B (default: inf)", command.t_max, parse_limit);
  group.value("--entry-min", "E", "of rays with --radius: spheres entered at E or later, metres",
              command.entry_min, parse_limit);
  group.value("--class", "LIST", "points of these classes, as 2,6", command.classes, parse_classes);
  group.count("--max-level", "N",
              "a thinned cloud: points of the levels 0 .. N of a layered octree; made for cloud files, while "
              "an index file must be one (alidade index --organisation layered)",
              command.max_level, 0, k_all_levels);
}

void add_copc(const Options& query, QueryCommand& command) {
  const Options group = query.group("COPC");
  group.flag("--load",
             "read the whole cloud and build an octree, also of a COPC file, which else is asked where it "
             "lies; pays from some thousands of targets on, the more the larger the file",
             command.is_loaded);
  group.value("--memory", "SIZE",
              "points of a COPC file to keep in memory: bytes, or a number with k, M, G or T (default: 512M)",
              command.memory, parse_size);
}

void add_answers(const Options& query, QueryCommand& command) {
  const Options group = query.group("Answers");
  const Option occluded =
      group.flag("--occluded", "only whether there is any point: 0 or 1 per target", command.occluded);
  group.flag("--count", "only how many points there are, up to K", command.count).excludes(occluded);
  group.file("-o,--output", "FILE", "file to write: .csv, .jsonl, .las or .laz (default: CSV to stdout)",
             command.output);
  group.choice("--format", "form of the answers, whatever the file is called", command.format,
               {{"csv", AnswerForm::csv}, {"jsonl", AnswerForm::json_lines}, {"las", AnswerForm::las}});
  group.flag("--overwrite", "replace an existing file", command.overwrite);
  group.flag("--explain", "say on stderr what work it was: nodes, points, and what was pruned by which rule",
             command.explain);
}

[[noreturn]] void refuse(const char* option, const FamilyWords& words) {
  throw Error({.problem = fmt::format("{} is not for {}", option, words.kind().plural)});
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
      throw Error({.problem = fmt::format("targets are given in two ways: {} and {}", k_families[i].texts,
                                          k_families[i].value),
                   .expected = "one of them"});
    }
    if (chosen) {
      throw Error({.problem = fmt::format("targets of two kinds are given: {} and {}",
                                          k_families[*chosen].kind().plural, k_families[i].kind().plural),
                   .expected = "one kind in a run"});
    }
    chosen = i;
  }
  if (!chosen) throw Error({.problem = "nothing to ask for", .expected = "one of " + all});
  return static_cast<TargetFamily>(*chosen);
}

/// Errors: an option was given that means nothing for this family, or without another.
void check_options(const QueryCommand& command) {
  using enum TargetFamily;
  const TargetFamily family = command.family;
  const FamilyWords& words = k_families[static_cast<std::size_t>(family)];
  const bool has_t = family == rays || family == cones || family == path;
  if (command.radius && (family == cones || family == planes || family == boxes)) refuse("--radius", words);
  if (command.measure && !has_t) refuse("--measure", words);
  if (command.t_min && !has_t) refuse("--t-min", words);
  if (command.t_max && !has_t) refuse("--t-max", words);
  if (command.entry_min && family != rays) refuse("--entry-min", words);
  if (command.entry_min && !command.radius)
    throw Error({.problem = "--entry-min needs a radius", .expected = "--radius R"});
  if (command.measure == Measure::entry && family == rays && !command.radius)
    throw Error({.problem = "--measure entry needs a radius", .expected = "--radius R"});
  if (command.measure == Measure::entry && family == path)
    throw Error({.problem = "--measure entry is not for paths", .expected = "t or distance"});
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
  const std::string ending = file_ending(command.output);
  std::optional<AnswerForm> form = command.format;
  if (!form && command.output.empty()) form = AnswerForm::csv;
  if (!form && ending == ".csv") form = AnswerForm::csv;
  if (!form && (ending == ".jsonl" || ending == ".ndjson")) form = AnswerForm::json_lines;
  if (!form && (ending == ".las" || ending == ".laz")) form = AnswerForm::las;
  if (!form) {
    throw Error({.file = command.output.string(),
                 .problem = "the name does not tell the form of the answers",
                 .expected = ".csv, .jsonl, .las or .laz, or --format"});
  }
  if (form == AnswerForm::las && command.output.empty())
    throw Error({.problem = "LAS is not written to stdout", .expected = "-o FILE.las"});
  if (form == AnswerForm::las && (command.count || command.occluded)) {
    throw Error({.file = command.output.string(),
                 .problem = "LAS holds points, not the numbers of --count and --occluded",
                 .expected = ".csv or .jsonl"});
  }
  return *form;
}

Command add_query(const Options& program) {
  const Options query =
      program.command("query", "Find the points that rays, cones, paths, planes, boxes or places meet");
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
