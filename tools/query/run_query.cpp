// SPDX-License-Identifier: MIT
#include "tools/query/query.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>

#include "cloud/rows.h"
#include "tools/cloud/load_cloud.h"
#include "tools/image_module.h"
#include "tools/query/queried_cloud.h"
#include "tools/query/target_reader.h"

namespace alidade::tools {
namespace {

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
    size.learn(batch.targets.size(), rows, std::chrono::duration<double>(Clock::now() - begin).count());
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
  ProgressLine line("asking", std::string(kind.plural), to_terminal ? Verbosity::quiet : command.verbosity);
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
  const geo::RemoteTraffic traffic = image_module().remote_traffic();
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

}  // namespace

ExitCode run_query(const QueryCommand& command) {
  // In the order of TargetFamily.
  constexpr ExitCode (*k_runs[k_target_families])(const QueryCommand&) = {
      run_with<Ray>,        run_with<Ray>,    run_with<Cone>,      run_with<Path>,
      run_with<HalfSpaces>, run_with<Bounds>, run_with<glm::dvec3>};
  return k_runs[static_cast<std::size_t>(command.family)](command);
}

}  // namespace alidade::tools
