// SPDX-License-Identifier: MIT
#include "tools/query/query.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cctype>
#include <chrono>

#include "base/words.h"
#include "cloud/rows.h"
#include "geo/remote_file.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/query/queried_cloud.h"
#include "tools/query/target_reader.h"

namespace alidade::tools {
namespace {

void add_targets(const Fields& query, QueryCommand& command) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const TargetKind& kind = target_kind(static_cast<TargetFamily>(i));
    GivenTargets& given = command.targets[i];
    query.group("Targets").text(kind.texts_option, "FILE|-", kind.help, given.text);
    std::string form = kind.form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.group("Targets").text(kind.value_option, form, "one target; repeatable", given.values);
  }
}

void add_conditions(const Fields& query, QueryCommand& command) {
  const Fields group = query.group("Conditions");
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

void add_copc(const Fields& query, QueryCommand& command) {
  const Fields group = query.group("COPC");
  group.flag("--load",
             "read the whole cloud and build an octree, also for a COPC file, which is otherwise queried in "
             "place; faster from some thousands of targets on, more for larger files",
             command.is_loaded);
  group.value("--memory", "SIZE",
              "memory for points of COPC files: bytes, or a number with k, M, G or T (default: 512M)",
              command.memory, parse_size);
}

void add_answers(const Fields& query, QueryCommand& command) {
  const Fields group = query.group("Answers");
  const Field occluded =
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

/// The form of the output: --format, else by the extension of its name; csv for stdout. Errors: another
/// extension; las without a file, or for numbers only.
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

/// The table of --explain: the work of a run in all and for each target.
std::string explain_table(const QueryStatistics& statistics, const TargetKind& kind, std::uint64_t targets,
                          std::uint64_t answers) {
  std::string text = fmt::format("{:<22}{:>16}{:>16}\n", "", "in all", fmt::format("per {}", kind.name));
  const auto row = [&](const char* name, std::uint64_t count) {
    const double mean = targets > 0 ? static_cast<double>(count) / static_cast<double>(targets) : 0.0;
    text += fmt::format("{:<22}{:>16}{:>16.2f}\n", name, count, mean);
  };
  row(std::string(kind.plural).c_str(), targets);
  row("nodes visited", statistics.nodes_visited);
  row("leaves visited", statistics.leaves_visited);
  row("points tested", statistics.points_tested);
  row("pruned by distance", statistics.pruned_by_distance);
  row("pruned by interval", statistics.pruned_by_interval);
  row("pruned by k", statistics.pruned_by_k);
  row("rows answered", answers);
  return text;
}

using Clock = std::chrono::steady_clock;

constexpr std::size_t k_explained_batch = 256;

bool only_numbers(const QueryCommand& command) {
  return command.count || command.occluded;
}

/// The query of the library, without the filter, which needs the cloud.
template <class Target>
typename QueryFamily<Target>::Query conditions(const QueryCommand& command) {
  typename QueryFamily<Target>::Query query;
  constexpr bool has_radius = requires {
    query.radius;
  }
  &&!std::is_same_v<Target, Bounds> && !std::is_same_v<Target, HalfSpaces>;
  bool is_bounded = true;
  if constexpr (has_radius) {
    query.radius = command.radius.value_or(k_unlimited_radius);
    is_bounded = command.radius.has_value();
  }
  query.k = command.k.value_or(is_bounded || only_numbers(command) ? k_all : 1);
  if constexpr (std::is_same_v<Target, Ray>) {
    query.measure = command.measure.value_or(command.radius ? Measure::entry : Measure::distance);
    query.entry_min = command.entry_min.value_or(query.entry_min);
  } else if constexpr (requires { query.measure; }) {
    query.measure = command.measure.value_or(query.measure);
  }
  query.max_level = command.max_level.value_or(k_all_levels);
  check_conditions<Target>(query);
  return query;
}

AttributeSet needed_attributes(const QueryCommand& command, bool all) {
  if (all) return AttributeSet::all();
  return command.classes ? AttributeSet(Attribute::classification) : AttributeSet();
}

[[noreturn]] void reject_classes(const QueryCommand& command) {
  throw file_error(command.files.first_name(), "--classes requires classification", "a classified cloud");
}

/// Answers with other numbers of the points, in unchanged order.
class RenumberedAnswers final : public AnswerOutput {
 public:
  using Ids = std::function<std::uint64_t(std::uint64_t row)>;

  RenumberedAnswers(std::unique_ptr<AnswerOutput> output, Ids ids)
      : output_(std::move(output)), ids_(std::move(ids)) {}

  void write(const AnswerRows& rows) override {
    output_->write({rows.size, [this, &rows](std::size_t first, std::span<AnswerRow> some) {
                      rows.fill(first, some);
                      for (AnswerRow& row : some) row.point_id = ids_(row.point_id);
                    }});
  }
  void finish() override { output_->finish(); }

 private:
  std::unique_ptr<AnswerOutput> output_;
  Ids ids_;
};

/// A cloud, all or some of whose points have been loaded.
struct QueriedCloud {
  IndexedCloud indexed;
  std::optional<database::CloudPart> part{};  ///< of a database; its cloud has been moved from
};

IndexedCloud load(const QueryCommand& command, bool all_attributes, const std::optional<Bounds>& region) {
  IndexCloudOptions options;
  options.read.region = region;
  options.read.attributes = needed_attributes(command, all_attributes);
  if (command.max_level) options.build.organisation = Organisation::layered;
  IndexedCloud cloud = load_shown(command, options);
  const std::size_t all_files = cloud.cloud.files.size();
  const std::size_t skipped_files = RowIds(cloud.cloud.files).skipped_files();
  if (skipped_files > 0)
    say_note(command.verbosity, fmt::format("read {} of {} files: no target reaches the bounds of the others",
                                            all_files - skipped_files, all_files));
  if (command.max_level && cloud.octree.view().organisation != Organisation::layered) {
    throw file_error(command.files.first_name(), "--max-level requires a layered index",
                     "a layered index (alidade index --organisation layered)");
  }
  return cloud;
}

/// The part of the cloud that the targets need, or all of it if that is unknown.
template <class Target>
QueriedCloud load_needed(const QueryCommand& command, AnswerForm form) {
  const bool all_attributes = form == AnswerForm::las;
  const char* const unit = part_unit(command.files.inputs.front());
  ProgressLine line(fmt::format("loading {}", unit), unit, command.verbosity);
  QueriedCloud cloud;
  cloud.part = read_query_part<Target>(command, needed_attributes(command, all_attributes), line.callback());
  // A LAS file has the columns of the cloud even if it has no points.
  if (cloud.part && cloud.part->ids.empty() && all_attributes) cloud.part.reset();
  if (!cloud.part) {
    cloud.indexed = load(command, all_attributes, query_region<Target>(command, form));
    return cloud;
  }
  line.finish();
  if (command.classes && !cloud.part->attributes.contains(Attribute::classification)) reject_classes(command);
  cloud.indexed.cloud = std::move(cloud.part->cloud);
  cloud.indexed.octree = build(std::move(cloud.indexed.cloud));
  return cloud;
}

/// Admits points of the chosen classes. `cloud` must outlive it.
CandidateFilter class_filter(const QueryCommand& command, const IndexedCloud& cloud) {
  if (!command.classes || cloud.octree.size() == 0) return {};
  const std::span<const std::uint8_t> classifications = cloud.columns().classifications;
  if (classifications.empty()) {
    // Points of files without classes have class 0 beside files with classes, even if none of these was read.
    if (RowIds(cloud.cloud.files).skipped_files() > 0)
      return [is_wanted = command.classes->test(0)](const Candidate&) { return is_wanted; };
    reject_classes(command);
  }
  return [classes = *command.classes, classifications](const Candidate& point) {
    return classes.test(classifications[point.point_id]);
  };
}

/// `ids` holds the numbers of points, if they are not their rows.
template <class Target>
std::unique_ptr<AnswerOutput> open_text(const QueryCommand& command, AnswerForm form, const Lattice& lattice,
                                        RenumberedAnswers::Ids ids = {}) {
  NumberForm numbers{.digits = command.precision};
  for (int axis = 0; axis < 3 && !command.precision; ++axis)
    numbers.decimals[static_cast<std::size_t>(axis)] = shown_decimals(lattice, axis);
  auto columns = command.occluded ? number_columns<Target>("occluded")
                 : command.count  ? number_columns<Target>("count")
                                  : answer_columns<Target>();
  std::unique_ptr<OutputFile> file;
  if (!command.output.empty()) file = std::make_unique<OutputFile>(command.output, command.overwrite);
  auto text = answers_as_text(std::move(columns), form, numbers, std::move(file));
  if (!ids || only_numbers(command)) return text;
  return std::make_unique<RenumberedAnswers>(std::move(text), std::move(ids));
}

/// The numbers that points have in the whole cloud; empty if they are the rows. The cloud must outlive them.
RenumberedAnswers::Ids ids_of(const QueriedCloud& cloud) {
  if (cloud.part) return [&ids = cloud.part->ids](std::uint64_t row) { return ids[row]; };
  RowIds ids(cloud.indexed.cloud.files);
  return ids.skipped_files() == 0 ? RenumberedAnswers::Ids() : RenumberedAnswers::Ids(std::move(ids));
}

/// Writes the answers of a batch, in the order of the targets; returns their number. No more than `limit` of
/// each target are held at once, but for a single target that has more.
template <class Target, class Executor>
std::size_t answer_batch(Executor& executor, const TargetBatch<Target>& batch, std::size_t limit,
                         AnswerOutput& output) {
  const std::span<const Target> targets = batch.targets;
  const std::span<const std::uint64_t> ids = batch.ids;
  const bool is_limited = executor.k() > limit;
  const auto answers = executor.find(targets, is_limited ? limit + 1 : k_all);
  std::size_t first = 0, written = 0;
  const auto write = [&](const auto& some, std::size_t begin, std::size_t end,
                         std::span<const std::uint64_t> their_ids) {
    written += some.begin[end] - some.begin[begin];
    output.write(answer_rows(some, begin, end, their_ids));
  };
  for (std::size_t i = 0; is_limited && i < targets.size(); ++i) {
    if (answers[i].size() <= limit) continue;
    write(answers, first, i, ids);
    write(executor.find(targets.subspan(i, 1), k_all), 0, 1, ids.subspan(i, 1));
    first = i + 1;
  }
  write(answers, first, targets.size(), ids);
  return written;
}

template <class Target, class Executor>
std::size_t count_batch(Executor& executor, const TargetBatch<Target>& batch, bool any_is_enough,
                        AnswerOutput& output) {
  const std::vector<std::size_t> counts = executor.count(batch.targets, any_is_enough);
  output.write(number_rows(counts, batch.ids));
  return counts.size();
}

/// The expected number of targets, if so many took this share of their text; 0 if the share is not known.
std::uint64_t expected_targets(std::uint64_t targets, double share) {
  if (share == 0.0) return 0;
  return std::max(targets, static_cast<std::uint64_t>(static_cast<double>(targets) / share));
}

struct Tally {
  std::uint64_t targets = 0, rows = 0;
};

/// Reads and queries all targets and writes their answers.
template <class Target, class Executor>
Tally answer_all_targets(TargetReader<Target>& reader, Executor& executor, const QueryCommand& command,
                         AnswerOutput& output, const Progress& progress) {
  Tally tally;
  BatchSize size;
  TargetBatch<Target> batch;
  // Work is counted once: a target whose work is counted is never queried twice.
  while (reader.next(command.explain ? std::min(size.targets(), k_explained_batch) : size.targets(), batch)) {
    const auto begin = Clock::now();
    const std::size_t rows =
        only_numbers(command)
            ? count_batch(executor, batch, command.occluded, output)
            : answer_batch(executor, batch, command.explain ? k_all : size.answers_per_target(), output);
    size.learn(batch.targets.size(), rows, Clock::now() - begin);
    tally.targets += batch.targets.size();
    tally.rows += rows;
    report(progress, tally.targets, expected_targets(tally.targets, reader.share()));
  }
  report(progress, tally.targets, tally.targets);
  return tally;
}

/// answer_all_targets() with a progress line; then ends the output. Returns the work as a table.
template <class Target, class Executor>
std::string run_targets(TargetReader<Target>& reader, Executor& executor, const QueryCommand& command,
                        AnswerOutput& output) {
  // Two texts on one terminal would run into each other.
  const bool to_terminal = command.output.empty() && isatty(STDOUT_FILENO) == 1;
  const TargetKind& kind = target_kind(command.family);
  ProgressLine line("querying", std::string(kind.plural), to_terminal ? Verbosity::quiet : command.verbosity);
  const Tally tally = answer_all_targets(reader, executor, command, output, line.callback());
  output.finish();
  line.finish();
  if (!command.output.empty())
    say_note(command.verbosity,
             fmt::format("{} {} in {}", tally.rows, only_numbers(command) ? "rows" : "points found",
                         command.output.string()));
  return explain_table(executor.statistics(), kind, tally.targets, tally.rows);
}

/// Reports mistakes in the first targets before the cloud is loaded, unless they come through a pipe.
template <class Target>
void check_first_targets(const QueryCommand& command) {
  constexpr std::size_t k_few = 1000;
  std::error_code error;
  const std::string& text = command.given().text;
  if (!text.empty() && !std::filesystem::is_regular_file(text, error)) return;
  TargetReader<Target> reader(open_targets(command), {command.t_min, command.t_max});
  TargetBatch<Target> batch;
  reader.next(k_few, batch);
}

bool is_any_remote(const CloudInputs& clouds) {
  return std::ranges::any_of(clouds.inputs, [](const CloudInput& input) {
    return !input.memory && is_remote_name(input.name.string());
  });
}

/// What was fetched from servers, as lines of a table; empty if all files are on this machine.
std::string traffic_table(const CloudInputs& clouds) {
  if (!is_any_remote(clouds)) return "";
  const geo::RemoteTraffic traffic = geo::remote_traffic();
  return fmt::format("{:<22}{:>16}\n{:<22}{:>16}\n", "remote requests", traffic.requests, "remote bytes",
                     traffic.bytes);
}

template <class Target>
ExitCode run_with(const QueryCommand& command) {
  const AnswerForm form = chosen_form(command);
  auto query = conditions<Target>(command);
  if (!command.output.empty())
    check_writable(command.output, command.overwrite, command.inputs({command.given().text}));
  check_first_targets<Target>(command);
  TargetReader<Target> reader(open_targets(command), {command.t_min, command.t_max});
  std::string table;
  if (queries_in_place(command, form)) {
    const std::unique_ptr<CopcTiles> tiles = open_copc(command);
    say_warnings(command.verbosity, tiles->warnings());
    const std::unique_ptr<AnswerOutput> output = open_text<Target>(command, form, tiles->lattice());
    TilesExecutor<Target> executor(*tiles, is_any_remote(command.files), query);
    table = run_targets(reader, executor, command, *output);
    table += copc_table(*tiles);
  } else {
    if (command.memory)
      throw input_error("--memory requires a COPC query without --load",
                        "a single COPC file, or a catalog of such");
    const QueriedCloud queried = load_needed<Target>(command, form);
    const IndexedCloud& cloud = queried.indexed;
    query.filter = class_filter(command, cloud);
    const std::unique_ptr<AnswerOutput> output =
        form == AnswerForm::las ? answers_as_las(command.output, command.overwrite, cloud,
                                                 answer_dimensions<Target>(), command.verbosity)
                                : open_text<Target>(command, form, cloud.octree.lattice(), ids_of(queried));
    QueryExecutor<Target> executor(cloud.octree, query, command.explain);
    table = run_targets(reader, executor, command, *output);
    if (queried.part) table += part_table(*queried.part);
  }
  if (command.explain) write_to_stderr(table + traffic_table(command.files));
  return ExitCode::done;
}

/// Runs the command: reads targets, queries the octree batch by batch in parallel, writes the answers. Memory
/// beside cloud and octree: about 200 MB at most, whatever the number of targets and answers; a single target
/// with more than a million answers takes what these take; if work is explained, some dozens of them. Errors:
/// of options that exclude each other, of cloud, targets and output.
ExitCode run(const QueryCommand& given) {
  QueryCommand command = given;
  command.family = chosen_family(command);
  check_options(command);
  // The library's rays are whole lines, as the paper's.
  if (command.family == TargetFamily::rays && !command.t_min) command.t_min = 0.0;
  // In the order of TargetFamily.
  constexpr ExitCode (*k_runs[k_target_families])(const QueryCommand&) = {
      run_with<Ray>,        run_with<Ray>,    run_with<Cone>,      run_with<Path>,
      run_with<HalfSpaces>, run_with<Bounds>, run_with<glm::dvec3>};
  return k_runs[static_cast<std::size_t>(command.family)](command);
}

}  // namespace

LineSource open_targets(const QueryCommand& command) {
  const GivenTargets& given = command.given();
  if (!given.text.empty()) return LineSource::open(given.text);
  return LineSource::command_line(target_kind(command.family).value_option, given.values);
}

Command add_query(const Options& program) {
  const Options query = program.command(
      "query", "Find the points near rays, paths and positions, and in cones, planes and boxes");
  auto command = std::make_shared<QueryCommand>();
  add_cloud(query, command->files, {"--classes"});
  add_targets(query, *command);
  add_conditions(query, *command);
  add_answers(query, *command);
  add_copc(query, *command);
  add_run_options(query, *command);
  return command_of(query, command, run);
}

}  // namespace alidade::tools
