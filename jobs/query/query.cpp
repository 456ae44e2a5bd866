// SPDX-License-Identifier: MIT
#include "jobs/query/query.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "base/remote_map.h"
#include "base/words.h"
#include "geo/remote_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/query/queried_cloud.h"
#include "octree/check_query.h"
#include "octree/explained_query.h"

namespace alidade::jobs {
namespace {

void add_targets(const Fields& query, QueryRequest& request) {
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const TargetKind& kind = target_kind(static_cast<TargetFamily>(i));
    GivenTargets& given = request.targets[i];
    query.group("Targets").text(kind.texts_option, "FILE|-", kind.help, given.text);
    std::string form = kind.form();
    std::ranges::transform(form, form.begin(), [](unsigned char c) { return std::toupper(c); });
    query.group("Targets").text(kind.value_option, form, "one target; repeatable", given.values);
  }
}

void add_conditions(const Fields& query, QueryRequest& request) {
  const Fields group = query.group("Conditions");
  group.value("--radius", "R", "largest distance from the ray, path or point, in metres (default: inf)",
              request.radius, parse_length_limit);
  group.count("--k", "K",
              "most points per target, in the order of the measure (default: 1 for rays, lines, paths and "
              "points without --radius, else all)",
              request.k, 1, k_all);
  group.choice("--measure",
               "order of points: distance to the ray, position t of the projection, or where the ray enters "
               "the sphere of the radius around the point (default: rays and lines entry with --radius, else "
               "distance; cones distance; paths t)",
               request.measure,
               {{"distance", Measure::distance}, {"t", Measure::t}, {"entry", Measure::entry}});
  group.value(
      "--t-min", "A",
      "points that project to t >= A, metres along the ray, line, cone or path, if the targets do not "
      "set it (default: rays and cones 0, lines and paths -inf)",
      request.t_min, parse_limit);
  group.value("--t-max", "B", "points that project to t <= B (default: inf)", request.t_max, parse_limit);
  group.value("--entry-min", "E", "for rays and lines with --radius: spheres entered at E or later, metres",
              request.entry_min, parse_limit);
  group.value("--classes,--class", "LIST",
              "points of these classes, such as 2,6; point ids stay those of all points", request.classes,
              parse_classes);
  group.count("--max-level", "N",
              "a thinned cloud: levels 0 to N of a layered octree; built for cloud files, while an index "
              "file must be layered (alidade index --organisation layered)",
              request.max_level, 0, k_all_levels);
}

void add_copc(const Fields& query, QueryRequest& request) {
  const Fields group = query.group("COPC");
  group.flag("--load",
             "read the whole cloud and build an octree, also for a COPC file, which is otherwise queried in "
             "place; faster from some thousands of targets on, more for larger files",
             request.is_loaded);
  group.value("--memory", "SIZE",
              "memory for points of COPC files: bytes, or a number with k, M, G or T (default: 512M)",
              request.memory, parse_size);
}

void add_answers(const Fields& query, QueryRequest& request) {
  const Fields group = query.group("Answers");
  const Field occluded =
      group.flag("--occluded", "only whether any point matches: 0 or 1 per target", request.occluded);
  group.excludes(occluded).flag("--count", "only the number of matching points, up to K", request.count);
  group.count(
      "--precision", "N",
      "significant digits of all numbers in CSV and JSON, 1 to 17 (default: coordinates have the decimals of "
      "the cloud, other numbers as many as give the same number again)",
      request.precision, 1, 17);
  group.file("-o,--output", "FILE", "output file: .csv, .jsonl, .las or .laz (default: CSV to stdout)",
             request.output);
  group.choice("--format", "output format, whatever the extension", request.format,
               {{"csv", AnswerForm::csv}, {"jsonl", AnswerForm::json_lines}, {"las", AnswerForm::las}});
  group.flag("--overwrite", "replace an existing file", request.overwrite);
  group.flag("--explain", "print the cost on stderr: nodes, points, and what each rule pruned",
             request.explain);
}

[[noreturn]] void reject(const char* option, TargetFamily family) {
  throw Error({.problem = fmt::format("{} does not apply to {}", option, target_kind(family).plural)});
}

/// The family of the given targets. Errors: no targets, several families, or one given in two ways.
TargetFamily chosen_family(const QueryRequest& request) {
  std::optional<TargetFamily> chosen;
  std::string all;
  for (std::size_t i = 0; i < k_target_families; ++i) {
    const GivenTargets& given = request.targets[i];
    const TargetKind& kind = target_kind(static_cast<TargetFamily>(i));
    all += (all.empty() ? "" : ", ") + std::string(kind.texts_option);
    if (given.empty()) continue;
    if (int{!given.text.empty()} + int{!given.values.empty()} + int{given.rows.has_value()} > 1) {
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

/// Errors: a field does not apply to this family, or requires another.
void check_fields(const QueryRequest& request, TargetFamily family) {
  using enum TargetFamily;
  const bool is_straight = family == rays || family == lines;
  const bool has_t = is_straight || family == cones || family == path;
  if (request.radius && (family == cones || family == planes || family == boxes)) reject("--radius", family);
  if (request.measure && !has_t) reject("--measure", family);
  if (request.t_min && !has_t) reject("--t-min", family);
  if (request.t_max && !has_t) reject("--t-max", family);
  if (request.entry_min && !is_straight) reject("--entry-min", family);
  if (request.entry_min && !request.radius) throw input_error("--entry-min requires a radius", "--radius R");
  if (request.measure == Measure::entry && is_straight && !request.radius)
    throw input_error("--measure entry requires a radius", "--radius R");
  if (request.measure == Measure::entry && family == path)
    throw input_error("--measure entry does not apply to paths", "t or distance");
}

/// The form of the output: --format, else by the extension of its name; csv for stdout. Errors: another
/// extension; las without a file, or for numbers only.
AnswerForm chosen_form(const QueryRequest& request) {
  const std::string extension = file_extension(request.output);
  std::optional<AnswerForm> form = request.format;
  if (!form && request.output.empty()) form = AnswerForm::csv;
  if (!form && extension == ".csv") form = AnswerForm::csv;
  if (!form && (extension == ".jsonl" || extension == ".ndjson")) form = AnswerForm::json_lines;
  if (!form && (extension == ".las" || extension == ".laz")) form = AnswerForm::las;
  if (!form)
    throw file_error(request.output, "unknown output format",
                     "the extension .csv, .jsonl, .las or .laz, or --format");
  if (form == AnswerForm::las && request.output.empty())
    throw input_error("LAS output requires a file", "-o FILE.las");
  if (form == AnswerForm::las && (request.count || request.occluded))
    throw file_error(request.output, "LAS cannot store --count and --occluded",
                     "the extension .csv or .jsonl");
  return *form;
}

/// Returns work(std::type_identity<Target>()) for the geometry of the targets of a family.
template <class Work>
auto with_geometry(TargetFamily family, const Work& work) {
  switch (family) {
    case TargetFamily::rays:
    case TargetFamily::lines:
      break;
    case TargetFamily::cones:
      return work(std::type_identity<Cone>());
    case TargetFamily::path:
      return work(std::type_identity<Path>());
    case TargetFamily::planes:
      return work(std::type_identity<HalfSpaces>());
    case TargetFamily::boxes:
      return work(std::type_identity<Bounds>());
    case TargetFamily::points:
      return work(std::type_identity<glm::dvec3>());
  }
  return work(std::type_identity<Ray>());
}

bool only_numbers(const QueryRequest& request) {
  return request.count || request.occluded;
}

/// The query of the library, without the filter, which needs the cloud.
template <class Target>
QueryOf<Target> conditions(const QueryRequest& request) {
  QueryOf<Target> query;
  bool is_bounded = true;
  if constexpr (requires { query.radius; } && !std::is_same_v<Target, Bounds> &&
                !std::is_same_v<Target, HalfSpaces>) {
    query.radius = request.radius.value_or(k_unlimited_radius);
    is_bounded = request.radius.has_value();
  }
  query.k = request.k.value_or(is_bounded || only_numbers(request) ? k_all : 1);
  if (request.occluded) query.k = 1;
  if constexpr (std::is_same_v<Target, Ray>) {
    query.measure = request.measure.value_or(request.radius ? Measure::entry : Measure::distance);
    query.entry_min = request.entry_min.value_or(query.entry_min);
  } else if constexpr (requires { query.measure; }) {
    query.measure = request.measure.value_or(query.measure);
  }
  query.max_level = request.max_level.value_or(k_all_levels);
  check_conditions<Target>(query);
  return query;
}

/// Reports mistakes in the first targets before the cloud is loaded, if they can be read again.
template <class Target>
void check_first_targets(const QueryRequest& request, TargetFamily family) {
  constexpr std::size_t k_few = 1000;
  const GivenTargets& given = request.given(family);
  if (!given.can_be_reread()) return;
  TargetReader<Target> reader(given, family, {request.t_min, request.t_max});
  TargetBatch<Target> batch;
  reader.next(k_few, batch);
}

/// How a batch is answered: by the functions of octree/query.h, or by Algorithm 1, which counts its steps.
template <class Target>
struct BatchQuery {
  /// The `most` first answers of each target.
  std::function<Answers<AnswerOf<Target>>(std::span<const Target>, std::size_t most)> find;
  std::function<void(std::span<const Target>, std::span<std::size_t> counts)> count;
  std::size_t k;
};

template <class Target>
BatchQuery<Target> batch_query(const Octree& octree, const QueryOf<Target>& query) {
  return {[&](std::span<const Target> targets, std::size_t most) {
            QueryOf<Target> some = query;
            some.k = std::min(query.k, most);
            return find(octree, targets, some);
          },
          [&](std::span<const Target> targets, std::span<std::size_t> counts) {
            count(octree, targets, query, counts);
          },
          query.k};
}

template <class Target, class Index>
BatchQuery<Target> explained_query(const Index& index, const QueryOf<Target>& query, QueryStatistics& work) {
  using Query = ExplainedQuery<Target, Index>;
  return {[&](std::span<const Target> targets, std::size_t most) {
            return Query::find(index, targets, query, most, work);
          },
          [&](std::span<const Target> targets, std::span<std::size_t> counts) {
            Query::count(index, targets, query, counts, work);
          },
          query.k};
}

/// Makes rows of answers and writes them.
class RowWriter {
 public:
  using Ids = std::function<std::uint64_t(std::uint64_t row)>;

  /// `point_ids`: of rows of the cloud; empty: the rows.
  RowWriter(std::unique_ptr<AnswerOutput> output, Ids point_ids)
      : output_(std::move(output)), point_ids_(std::move(point_ids)) {}

  /// The answers of the targets [begin, end). `ids`: of all targets.
  template <class Answer>
  void write(const Answers<Answer>& answers, std::size_t begin, std::size_t end,
             std::span<const std::uint64_t> ids) {
    const std::vector<std::size_t>& starts = answers.begin;
    const std::size_t before = starts[begin];
    put(starts[end] - before, [&](std::size_t first, std::span<AnswerRow> rows) {
      std::size_t i = before + first;
      auto target = static_cast<std::size_t>(std::ranges::upper_bound(starts, i) - starts.begin()) - 1;
      for (AnswerRow& row : rows) {
        while (starts[target + 1] <= i) ++target;
        row = row_of(answers.all[i]);
        if (point_ids_) row.point_id = point_ids_(row.point_id);
        row.target_id = ids[target];
        row.rank = i++ - starts[target];
      }
    });
  }
  void write(std::span<const std::size_t> counts, std::span<const std::uint64_t> ids) {
    put(counts.size(), [&](std::size_t first, std::span<AnswerRow> rows) {
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = {.target_id = ids[first + i], .count = counts[first + i]};
    });
  }
  void finish() { output_->finish(); }

  std::uint64_t written() const { return written_; }

 private:
  static constexpr std::size_t k_rows_at_once = 1 << 17, k_rows_per_task = 1 << 10;

  template <class Answer>
  static AnswerRow row_of(const Answer& hit) {
    AnswerRow row{.point_id = hit.point_id, .position = hit.position, .distance = hit.distance};
    if constexpr (requires { hit.t; }) row.t = hit.t;
    if constexpr (requires { hit.entry; }) row.entry = hit.entry;
    if constexpr (requires { hit.segment; }) row.segment = hit.segment;
    return row;
  }

  /// Writes so many rows, maybe none. fill(first, rows) makes some of them, from several threads at once.
  template <class Fill>
  void put(std::size_t count, const Fill& fill) {
    for (std::size_t first = 0; first == 0 || first < count; first += k_rows_at_once) {
      rows_.resize(std::min(k_rows_at_once, count - first));
      in_blocks(rows_.size(), k_rows_per_task, [&](std::size_t begin, std::size_t end) {
        fill(first + begin, std::span(rows_).subspan(begin, end - begin));
      });
      output_->write(rows_);
    }
    written_ += count;
  }

  std::unique_ptr<AnswerOutput> output_;
  Ids point_ids_;
  std::vector<AnswerRow> rows_;
  std::uint64_t written_ = 0;
};

/// Writes the answers of a batch, in the order of the targets. No more than `limit` of each target are held
/// at once, but for a single target that has more.
template <class Target>
void answer_batch(const BatchQuery<Target>& query, const TargetBatch<Target>& batch, std::size_t limit,
                  RowWriter& writer) {
  const std::span<const Target> targets = batch.targets;
  const std::span<const std::uint64_t> ids = batch.ids;
  const bool is_limited = query.k > limit;
  const auto answers = query.find(targets, is_limited ? limit + 1 : k_all);
  std::size_t first = 0;
  for (std::size_t i = 0; is_limited && i < targets.size(); ++i) {
    if (answers[i].size() <= limit) continue;
    writer.write(answers, first, i, ids);
    writer.write(query.find(targets.subspan(i, 1), k_all), 0, 1, ids.subspan(i, 1));
    first = i + 1;
  }
  writer.write(answers, first, targets.size(), ids);
}

template <class Target>
void count_batch(const BatchQuery<Target>& query, const TargetBatch<Target>& batch, RowWriter& writer) {
  std::vector<std::size_t> counts(batch.targets.size());
  query.count(batch.targets, counts);
  writer.write(counts, batch.ids);
}

/// The expected number of targets, if so many took this share of their text; 0 if the share is not known.
std::uint64_t expected_targets(std::uint64_t targets, double share) {
  if (share == 0.0) return 0;
  return std::max(targets, static_cast<std::uint64_t>(static_cast<double>(targets) / share));
}

/// Reads and queries all targets, and writes their answers. Returns the number of targets.
template <class Target>
std::uint64_t answer_targets(TargetReader<Target>& reader, const BatchQuery<Target>& query,
                             const QueryRequest& request, RowWriter& writer, const Progress& progress) {
  using Clock = PieceSize::Clock;
  constexpr std::size_t k_explained_batch = 256;
  std::uint64_t count = 0;
  BatchSize size;
  TargetBatch<Target> batch;
  // Work is counted once: a target whose work is counted is never queried twice.
  while (reader.next(request.explain ? std::min(size.targets(), k_explained_batch) : size.targets(), batch)) {
    const auto begin = Clock::now();
    const std::uint64_t before = writer.written();
    if (only_numbers(request)) {
      count_batch(query, batch, writer);
    } else {
      answer_batch(query, batch, request.explain ? k_all : size.answers_per_target(), writer);
    }
    size.learn(batch.targets.size(), writer.written() - before, Clock::now() - begin);
    count += batch.targets.size();
    report(progress, count, expected_targets(count, reader.share()));
  }
  report(progress, count, count);
  writer.finish();
  return count;
}

/// Keeps the rows.
class AnswerList final : public AnswerOutput {
 public:
  explicit AnswerList(std::vector<AnswerRow>& rows) : rows_(rows) {}
  void write(std::span<const AnswerRow> rows) override {
    rows_.insert(rows_.end(), rows.begin(), rows.end());
  }
  void finish() override {}

 private:
  std::vector<AnswerRow>& rows_;
};

/// Where the answers go, but for those in LAS.
std::unique_ptr<AnswerOutput> open_output(const QueryPlan& plan, const Lattice& lattice,
                                          QueryResult& result) {
  const QueryRequest& request = plan.request();
  if (request.output.empty() && !request.write_text) return std::make_unique<AnswerList>(result.rows);
  NumberForm numbers{.digits = request.precision};
  for (int axis = 0; axis < 3 && !request.precision; ++axis)
    numbers.decimals[static_cast<std::size_t>(axis)] = shown_decimals(lattice, axis);
  return answers_as_text(result.columns, plan.form(), numbers,
                         {request.output, request.overwrite, request.write_text});
}

/// The work of Algorithm 1 in all and for each target.
void add_steps(const QueryStatistics& steps, std::string_view targets, std::uint64_t target_count,
               std::uint64_t row_count, std::vector<WorkCount>& work) {
  const std::pair<std::string_view, std::uint64_t> counts[] = {
      {targets, target_count},
      {"nodes visited", steps.nodes_visited},
      {"leaves visited", steps.leaves_visited},
      {"points tested", steps.points_tested},
      {"pruned by distance", steps.pruned_by_distance},
      {"pruned by interval", steps.pruned_by_interval},
      {"pruned by k", steps.pruned_by_k},
      {"rows answered", row_count}};
  for (const auto& [name, count] : counts)
    work.push_back({.name = std::string(name), .count = count, .is_per_target = true});
}

/// Files opened, chunks and points decoded, and what share of all that is.
void add_reads(const CopcTiles& tiles, std::vector<WorkCount>& work) {
  const CopcTiles::Work reads = tiles.work();
  const bool are_many = tiles.size() > 1;
  if (are_many) work.push_back({"files opened", reads.files_opened, tiles.size()});
  work.push_back({are_many ? "their chunks read" : "chunks read", reads.reads.chunks_met, reads.chunk_count});
  work.push_back({"chunks decoded", reads.reads.chunks_decoded});
  work.push_back({"points decoded", reads.reads.points_decoded, tiles.point_count()});
}

void add_reads(const database::CloudPart& part, std::vector<WorkCount>& work) {
  if (part.chunk_count == 0) return work.push_back({"points read", part.ids.size()});
  work.push_back({"chunks read", part.chunks_read, part.chunk_count});
}

/// What was fetched from servers, if any file is on one.
void add_traffic(const CloudInputs& clouds, std::vector<WorkCount>& work) {
  const bool is_any_remote = std::ranges::any_of(clouds.inputs, [](const CloudInput& input) {
    return !input.memory && is_remote_name(input.name.string());
  });
  if (!is_any_remote) return;
  const geo::RemoteTraffic traffic = geo::remote_traffic();
  work.push_back({"remote requests", traffic.requests});
  work.push_back({"remote bytes", traffic.bytes});
}

/// One run on targets of one geometry.
template <class Target>
class QueryRun {
 public:
  QueryRun(const QueryPlan& plan, Listener& listener)
      : plan_(plan),
        request_(plan.request()),
        listener_(listener),
        query_(conditions<Target>(request_)),
        reader_(request_.given(plan.family()), plan.family(), {request_.t_min, request_.t_max},
                [&listener] { return listener.stops(); }) {
    result_.columns = request_.occluded ? number_columns(plan.family(), "occluded")
                      : request_.count  ? number_columns(plan.family(), "count")
                                        : answer_columns(plan.family());
  }

  QueryResult run() {
    if (queries_in_place(plan_)) {
      run_in_place();
    } else {
      run_loaded();
    }
    add_traffic(request_.files, result_.work);
    if (!request_.explain) result_.work.clear();
    RemoteMap::check_all();  // as OutputFile does, for answers that are only returned
    return std::move(result_);
  }

 private:
  void run_in_place() {
    const std::unique_ptr<CopcTiles> tiles = open_copc(request_, listener_);
    result_.crs = tiles->crs();
    answer(explained_query<Target>(*tiles, query_, steps_),
           {open_output(plan_, tiles->lattice(), result_), {}});
    add_reads(*tiles, result_.work);
  }

  void run_loaded() {
    const QueriedCloud queried = load_queried<Target>(plan_, listener_);
    const IndexedCloud& cloud = queried.indexed;
    result_.crs = cloud.cloud.crs;
    query_.filter = queried.class_filter(request_);
    const bool is_las = plan_.form() == AnswerForm::las;
    auto output = is_las
                      ? answers_as_las(request_.output, request_.overwrite, cloud, result_.columns, listener_)
                      : open_output(plan_, cloud.octree.lattice(), result_);
    answer(request_.explain ? explained_query<Target>(cloud.octree, query_, steps_)
                            : batch_query<Target>(cloud.octree, query_),
           {std::move(output), is_las ? RowWriter::Ids() : queried.ids()});
    if (queried.part) add_reads(*queried.part, result_.work);
  }

  void answer(const BatchQuery<Target>& query, RowWriter writer) {
    const TargetKind& kind = target_kind(plan_.family());
    SilentListener silent(listener_);
    Listener& heard = request_.is_text_shown && request_.output.empty() ? silent : listener_;
    const std::uint64_t count = in_stage(
        heard, "querying", std::string(kind.plural),
        [&](const Progress& progress) { return answer_targets(reader_, query, request_, writer, progress); });
    if (!request_.output.empty())
      listener_.note(fmt::format("{} {} in {}", writer.written(),
                                 only_numbers(request_) ? "rows" : "points found", request_.output.string()));
    add_steps(steps_, kind.plural, count, writer.written(), result_.work);
  }

  const QueryPlan& plan_;
  const QueryRequest& request_;
  Listener& listener_;
  QueryOf<Target> query_;
  TargetReader<Target> reader_;
  QueryStatistics steps_;
  QueryResult result_;
};

}  // namespace

void add_query_fields(const Fields& fields, QueryRequest& request) {
  add_cloud(fields, request.files, {"--classes"});
  add_targets(fields, request);
  add_conditions(fields, request);
  add_answers(fields, request);
  add_copc(fields, request);
  add_partial(fields, request.partial);
}

QueryPlan plan(const QueryRequest& given) {
  QueryRequest request = given;
  const TargetFamily family = chosen_family(request);
  check_fields(request, family);
  // The library's rays are whole lines, as the paper's.
  if (family == TargetFamily::rays && !request.t_min) request.t_min = 0.0;
  const AnswerForm form = chosen_form(request);
  PlannedWork work{.clouds = request.files,
                   .partial = request.partial,
                   .reads = {request.given(family).text},
                   .writes = {request.output}};
  with_geometry(family, [&]<class Target>(std::type_identity<Target>) {
    (void)conditions<Target>(request);
    check_outputs(work, request.overwrite);
    check_first_targets<Target>(request, family);
  });
  QueryPlan checked(std::move(request), std::move(work), family, form);
  if (checked.request().memory && !queries_in_place(checked))
    throw input_error("--memory requires a COPC query without --load",
                      "a single COPC file, or a catalog of such");
  return checked;
}

QueryResult run(const QueryPlan& plan, Listener& listener) {
  return with_geometry(plan.family(), [&]<class Target>(std::type_identity<Target>) {
    return QueryRun<Target>(plan, listener).run();
  });
}

}  // namespace alidade::jobs
