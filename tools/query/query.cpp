// SPDX-License-Identifier: MIT
#include "tools/query/query.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>

#include "base/error.h"
#include "base/words.h"
#include "tools/command.h"
#include "tools/options.h"
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

std::bitset<256> parse_classes(const std::string& text) {
  std::bitset<256> classes;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    classes.set(static_cast<std::size_t>(parse_count(text.substr(begin, end - begin), 0, 255)));
    if (end == text.size()) return classes;
    begin = end + 1;
  }
}

void add_targets(CLI::App& query, QueryCommand& command) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const FamilyWords& words = k_families[i];
    GivenTargets& given = command.targets[i];
    given.text_option = words.texts;
    given.value_option = words.value;
    query.add_option(words.texts, given.text, words.help)->option_text("FILE|-")->group("Targets");
    std::string form = words.kind().form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.add_option(words.value, given.values, "one of them; may be repeated")
        ->option_text(form)
        ->allow_extra_args(false)
        ->group("Targets");
  }
}

void add_conditions(CLI::App& query, QueryCommand& command) {
  const char* const group = "Conditions";
  add_value(query, "--radius", "R",
            "points at most so far from the ray, path or point, in metres (default: inf)",
            [&command](const std::string& text) { command.radius = parse_length_limit(text); })
      ->group(group);
  add_value(query, "--k", "K",
            "at most so many points, the first by the measure (default: 1 for rays, paths and points without "
            "--radius, else all)",
            [&command](const std::string& text) {
              command.k = static_cast<std::size_t>(parse_count(text, 1, k_all));
            })
      ->group(group);
  add_choice<Measure>(query, "--measure",
                      "what puts points into order: distance to the ray, place t of the projection, or where "
                      "the ray enters the sphere of the radius around the point (default: rays entry with "
                      "--radius, else distance; cones distance; paths t)",
                      command.measure,
                      {{"distance", Measure::distance}, {"t", Measure::t}, {"entry", Measure::entry}})
      ->group(group);
  add_value(query, "--t-min", "A",
            "points that project to t >= A, metres along the ray, cone or path, where the targets do not say "
            "it themselves (default: -inf; cones 0)",
            [&command](const std::string& text) { command.t_min = parse_limit(text); })
      ->group(group);
  add_value(query, "--t-max", "B", "points that project to t <= B (default: inf)",
            [&command](const std::string& text) { command.t_max = parse_limit(text); })
      ->group(group);
  add_value(query, "--entry-min", "E", "of rays with --radius: spheres entered at E or later, metres",
            [&command](const std::string& text) { command.entry_min = parse_limit(text); })
      ->group(group);
  add_value(query, "--class", "LIST", "points of these classes, as 2,6", [&command](const std::string& text) {
    command.classes = parse_classes(text);
  })->group(group);
  add_value(
      query, "--max-level", "N",
      "a thinned cloud: points of the levels 0 .. N of a layered octree; made for cloud files, while an "
      "index file must be one (alidade index --organisation layered)",
      [&command](const std::string& text) {
        command.max_level = static_cast<int>(parse_count(text, 0, k_all_levels));
      })
      ->group(group);
}

void add_copc(CLI::App& query, QueryCommand& command) {
  const char* const group = "COPC";
  query
      .add_flag("--load", command.is_loaded,
                "read the whole cloud and build an octree, also of a COPC file, which else is asked where it "
                "lies; pays from some thousands of targets on, the more the larger the file")
      ->group(group);
  add_value(query, "--memory", "SIZE",
            "points of a COPC file to keep in memory: bytes, or a number with k, M, G or T (default: 512M)",
            [&command](const std::string& text) { command.memory = parse_size(text); })
      ->group(group);
}

void add_answers(CLI::App& query, QueryCommand& command) {
  const char* const group = "Answers";
  CLI::Option* const occluded =
      query.add_flag("--occluded", command.occluded, "only whether there is any point: 0 or 1 per target")
          ->option_text(" ")
          ->group(group);
  query.add_flag("--count", command.count, "only how many points there are, up to K")
      ->excludes(occluded)
      ->option_text(" ")
      ->group(group);
  query
      .add_option("-o,--output", command.output,
                  "file to write: .csv, .jsonl, .las or .laz (default: CSV to stdout)")
      ->option_text("FILE")
      ->group(group);
  add_choice<AnswerForm>(
      query, "--format", "form of the answers, whatever the file is called", command.format,
      {{"csv", AnswerForm::csv}, {"jsonl", AnswerForm::json_lines}, {"las", AnswerForm::las}})
      ->group(group);
  query.add_flag("--overwrite", command.overwrite, "replace an existing file")->group(group);
  query
      .add_flag("--explain", command.explain,
                "say on stderr what work it was: nodes, points, and what was pruned by which rule")
      ->group(group);
}

[[noreturn]] void refuse(const char* option, const FamilyWords& words) {
  throw Error({.problem = fmt::format("{} is not for {}", option, words.kind().plural)});
}

}  // namespace

std::shared_ptr<QueryCommand> add_query_options(CLI::App& query) {
  auto command = std::make_shared<QueryCommand>();
  add_cloud_files(query, "cloud", command->files, k_cloud_help)->option_text("CLOUD...")->required();
  add_targets(query, *command);
  add_conditions(query, *command);
  add_answers(query, *command);
  add_copc(query, *command);
  add_partial(query, command->partial);
  add_threads(query, command->threads);
  add_verbosity(query, command->verbosity);
  return command;
}

TargetFamily chosen_family(const QueryCommand& command) {
  std::optional<std::size_t> chosen;
  std::string all;
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const GivenTargets& given = command.targets[i];
    all += (all.empty() ? "" : ", ") + given.text_option;
    const bool has_text = !given.text.empty(), has_values = !given.values.empty();
    if (!has_text && !has_values) continue;
    if (has_text && has_values) {
      throw Error({.problem = fmt::format("targets are given in two ways: {} and {}", given.text_option,
                                          given.value_option),
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

LineSource open_targets(const QueryCommand& command, TargetFamily family) {
  const GivenTargets& given = command.targets[static_cast<std::size_t>(family)];
  return given.text.empty() ? LineSource::command_line(given.value_option, given.values)
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

void check_options(const QueryCommand& command, TargetFamily family) {
  using enum TargetFamily;
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

namespace {

ExitCode run(const QueryCommand& command) {
  const TargetFamily family = chosen_family(command);
  check_options(command, family);
  switch (family) {
    case TargetFamily::rays:
      return run_query<Ray>(command, family);
    case TargetFamily::cones:
      return run_query<Cone>(command, family);
    case TargetFamily::path:
      return run_query<Path>(command, family);
    case TargetFamily::planes:
      return run_query<HalfSpaces>(command, family);
    case TargetFamily::boxes:
      return run_query<Bounds>(command, family);
    case TargetFamily::points:
      break;
  }
  return run_query<glm::dvec3>(command, family);
}

}  // namespace

Command add_query(CLI::App& program) {
  CLI::App* query = program.add_subcommand(
      "query", "Find the points that rays, cones, paths, planes, boxes or places meet");
  const std::shared_ptr<QueryCommand> command = add_query_options(*query);
  query->footer(
      "Forms:\n"
      "  alidade query CLOUD... --rays FILE [CONDITIONS] [-o FILE]\n"
      "  alidade query CLOUD... --ray OX,OY,OZ,DX,DY,DZ [CONDITIONS] [-o FILE]\n"
      "and likewise with --cones, --path, --planes, --boxes, --points. One kind of target in a run.\n"
      "\n"
      "Lengths and coordinates are in metres (the unit of the cloud's CRS), half angles in degrees. All "
      "limits "
      "are inclusive.\n"
      "All conditions hold together. Directions and normals may have any length but zero. A target whose "
      "interval or box\n"
      "is inverted (t_min > t_max) has no answers.\n"
      "\n"
      "Targets, as a file, a pipe, or - for standard input:\n"
      "  CSV         a header with the names of the columns in any order, then one row per ray (cone, box, "
      "place),\n"
      "              vertex of a path, or plane of a region. Optional columns stand in [brackets]; an empty "
      "cell in one\n"
      "              is as if it were not there. Limits may be inf or -inf. Blank lines are skipped.\n"
      "      rays    ox,oy,oz,dx,dy,dz[,t_min][,t_max]\n"
      "      cones   ox,oy,oz,dx,dy,dz,half_angle[,radius][,t_min][,t_max]\n"
      "      path    x,y,z[,path]\n"
      "      planes  px,py,pz,nx,ny,nz[,region]\n"
      "      boxes   min_x,min_y,min_z,max_x,max_y,max_z\n"
      "      points  x,y,z\n"
      "  JSON lines  an object per line with these names as keys, or with vectors: origin and direction "
      "(rays, "
      "cones),\n"
      "              position (path, points), point and normal (planes), min and max (boxes); or an array in "
      "this order.\n"
      "\n"
      "Answers stand in the order of the targets, each target's by the measure and then by point id. Ids and "
      "ranks count\n"
      "from 0; point_id is the row of the cloud. Numbers have 17 significant digits. A target without an "
      "answer has no row,\n"
      "but with --count and --occluded one row.\n"
      "      rays    ray_id,rank,point_id,x,y,z,t,distance,entry    entry is -inf without --radius\n"
      "      cones   cone_id,rank,point_id,x,y,z,t,distance,entry\n"
      "      path    path_id,rank,point_id,x,y,z,segment,t,distance    t along the path from its first "
      "vertex\n"
      "      planes  region_id,rank,point_id,x,y,z,distance    to the region's first plane\n"
      "      boxes   box_id,rank,point_id,x,y,z\n"
      "      points  query_id,rank,point_id,x,y,z,distance\n"
      "      --count ray_id,count; --occluded ray_id,occluded (0 or 1); and so on\n"
      "  .jsonl      an object per row with the same keys; null for an infinite number\n"
      "  .las, .laz  LAS 1.4: a point per row with all its attributes and the extra bytes Distance (double), "
      "RayT (double)\n"
      "              and RayId (uint64); ConeT, ConeId, PathT, PathId, RegionId, BoxId, QueryId for the "
      "others\n"
      "\n"
      "Targets and answers are streamed: any number of them takes little memory. --explain asks by the plain "
      "form of\n"
      "Algorithm 1, whose steps are counted; answers are the same, but slower.\n"
      "\n"
      "Examples:\n"
      "  alidade query site.las --rays rays.csv --radius 0.05 --k 1 -o first_hits.csv\n"
      "  alidade query site.alidade --ray 0,0,30,0,0,-1 --radius 0.1 --measure t\n"
      "  alidade query site.las --path road.csv --radius 2 --class 2 -o profile.las\n"
      "  alidade query site.las --point 1.5,2,0 --k 8\n"
      "  make_rays | alidade query site.las --rays - --radius 0.05 --occluded > shadows.csv\n");
  return {query, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade::tools
