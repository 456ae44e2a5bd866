// SPDX-License-Identifier: MIT
#include "jobs/query/query.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "base/words.h"
#include "jobs/cloud_fields.h"
#include "jobs/cloud_formats.h"
#include "jobs/query/answers.h"
#include "jobs/query/queried_cloud.h"
#include "jobs/query/targets.h"
#include "jobs/remote_files.h"
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
void check_fields(const CheckedQuery& request) {
  using enum TargetFamily;
  const TargetFamily family = request.family;
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

/// The query of the library, without the filter, which needs the cloud.
template <class Target>
QueryOf<Target> conditions(const CheckedQuery& request) {
  QueryOf<Target> query;
  bool is_bounded = true;
  if constexpr (requires { query.radius; } && !QueryFamily<Target>::limits_itself) {
    query.radius = request.radius.value_or(k_unlimited_radius);
    is_bounded = request.radius.has_value();
  }
  query.k = request.k.value_or(is_bounded || request.has_only_numbers() ? k_all : 1);
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
void check_first_targets(const CheckedQuery& query) {
  constexpr std::size_t k_few = 1000;
  if (!query.given_targets().can_be_reread()) return;
  TargetReader<Target> reader(query);
  TargetBatch<Target> batch;
  reader.next(k_few, batch);
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

/// The found point without its target and rank.
template <class Answer>
AnswerRow row_of(const Answer& hit) {
  AnswerRow row{.point_id = hit.point_id, .position = hit.position, .distance = hit.distance};
  if constexpr (requires { hit.t; }) row.t = hit.t;
  if constexpr (requires { hit.entry; }) row.entry = hit.entry;
  if constexpr (requires { hit.segment; }) row.segment = hit.segment;
  return row;
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
  const RemoteTraffic traffic = remote_traffic();
  work.push_back({"remote requests", traffic.requests});
  work.push_back({"remote bytes", traffic.bytes});
}

/// One run on targets of one geometry.
template <class Target>
class QueryRun {
 public:
  QueryRun(const CheckedQuery& request, Listener& listener)
      : request_(request),
        listener_(listener),
        query_(conditions<Target>(request)),
        reader_(request, [&listener] { return listener.stops(); }) {}

  QueryResult run() {
    result_.columns = answer_columns(request_);
    if (queries_in_place(request_)) {
      tiles_ = open_copc(request_, listener_);
      result_.crs = tiles_->crs();
      output_ = open_output(tiles_->lattice());
    } else {
      cloud_ = load_queried<Target>(request_, listener_);
      const IndexedCloud& indexed = cloud_->indexed;
      result_.crs = indexed.cloud.crs;
      query_.filter = cloud_->class_filter(request_);
      const bool is_las = request_.form == AnswerForm::las;
      if (!is_las) point_ids_ = cloud_->ids();
      output_ = is_las ? open_las(request_, indexed, listener_) : open_output(indexed.octree.lattice());
    }
    answer_shown();
    if (tiles_) add_reads(*tiles_, result_.work);
    if (cloud_ && cloud_->part) add_reads(*cloud_->part, result_.work);
    add_traffic(request_.files, result_.work);
    if (!request_.explain) result_.work.clear();
    return std::move(result_);
  }

 private:
  using Found = Answers<AnswerOf<Target>>;

  /// Where the answers go, but for those in LAS.
  std::unique_ptr<AnswerOutput> open_output(const Lattice& lattice) {
    if (request_.output.empty() && !request_.write_text) return std::make_unique<AnswerList>(result_.rows);
    return open_text(request_, lattice);
  }

  void answer_shown() {
    const std::string targets(target_kind(request_.family).plural);
    SilentListener silent(listener_);
    Listener& heard = request_.is_text_shown && request_.output.empty() ? silent : listener_;
    const std::uint64_t count = in_stage(heard, "querying", targets,
                                         [&](const Progress& progress) { return answer_targets(progress); });
    if (!request_.output.empty())
      listener_.note(fmt::format("{} {} in {}", written_,
                                 request_.has_only_numbers() ? "rows" : "points found",
                                 request_.output.string()));
    add_steps(steps_, targets, count, written_, result_.work);
  }

  /// Reads and queries all targets, and writes their answers. Returns the number of targets.
  std::uint64_t answer_targets(const Progress& progress) {
    using Clock = PieceSize::Clock;
    constexpr std::size_t k_explained_batch = 256;
    std::uint64_t count = 0;
    BatchSize size;
    // Work is counted once: a target whose work is counted is never queried twice.
    const auto most = [&] {
      return request_.explain ? std::min(size.targets(), k_explained_batch) : size.targets();
    };
    while (reader_.next(most(), batch_)) {
      const auto begin = Clock::now();
      const std::uint64_t before = written_;
      if (request_.has_only_numbers()) {
        count_batch();
      } else {
        answer_batch(request_.explain ? k_all : size.answers_per_target());
      }
      size.learn(batch_.targets.size(), written_ - before, Clock::now() - begin);
      count += batch_.targets.size();
      const double share = reader_.share();
      const double expected = share > 0.0 ? static_cast<double>(count) / share : 0.0;
      report(progress, count, share > 0.0 ? std::max(count, static_cast<std::uint64_t>(expected)) : 0);
    }
    report(progress, count, count);
    output_->finish();
    return count;
  }

  /// Writes the answers of the batch, in the order of the targets. No more than `limit` of each target are
  /// held at once, but for a single target that has more.
  void answer_batch(std::size_t limit) {
    const std::span<const Target> targets = batch_.targets;
    const bool is_limited = query_.k > limit;
    const Found answers = find(targets, is_limited ? limit + 1 : k_all);
    std::size_t first = 0;
    for (std::size_t i = 0; is_limited && i < targets.size(); ++i) {
      if (answers[i].size() <= limit) continue;
      write(answers, 0, first, i);
      write(find(targets.subspan(i, 1), k_all), i, 0, 1);
      first = i + 1;
    }
    write(answers, 0, first, targets.size());
  }

  void count_batch() {
    std::vector<std::size_t> counts(batch_.targets.size());
    const std::span<const Target> targets = batch_.targets;
    if (tiles_)
      ExplainedQuery<Target, CopcTiles>::count(*tiles_, targets, query_, counts, steps_);
    else if (request_.explain)
      ExplainedQuery<Target, Octree>::count(cloud_->indexed.octree, targets, query_, counts, steps_);
    else
      alidade::count(cloud_->indexed.octree, targets, query_, counts);
    put(counts.size(), [&](std::size_t first, std::span<AnswerRow> rows) {
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = {.target_id = batch_.ids[first + i], .count = counts[first + i]};
    });
  }

  /// The `most` first answers of each target, by Algorithm 1 if its steps are counted.
  Found find(std::span<const Target> targets, std::size_t most) {
    if (tiles_) return ExplainedQuery<Target, CopcTiles>::find(*tiles_, targets, query_, most, steps_);
    const Octree& octree = cloud_->indexed.octree;
    if (request_.explain) return ExplainedQuery<Target, Octree>::find(octree, targets, query_, most, steps_);
    QueryOf<Target> some = query_;
    some.k = std::min(query_.k, most);
    return alidade::find(octree, targets, some);
  }

  /// Writes the answers of the targets [begin, end) of those that are answered, which start at number `from`
  /// of the batch.
  void write(const Found& answers, std::size_t from, std::size_t begin, std::size_t end) {
    const std::vector<std::size_t>& starts = answers.begin;
    const std::size_t before = starts[begin];
    put(starts[end] - before, [&](std::size_t first, std::span<AnswerRow> rows) {
      std::size_t i = before + first;
      auto target = static_cast<std::size_t>(std::ranges::upper_bound(starts, i) - starts.begin()) - 1;
      for (AnswerRow& row : rows) {
        while (starts[target + 1] <= i) ++target;
        row = row_of(answers.all[i]);
        if (point_ids_) row.point_id = point_ids_(row.point_id);
        row.target_id = batch_.ids[from + target];
        row.rank = i++ - starts[target];
      }
    });
  }

  /// Writes so many rows, maybe none. fill(first, rows) makes some of them, from several threads at once.
  template <class Fill>
  void put(std::size_t count, const Fill& fill) {
    constexpr std::size_t k_rows_at_once = 1 << 17, k_rows_per_task = 1 << 10;
    for (std::size_t first = 0; first == 0 || first < count; first += k_rows_at_once) {
      rows_.resize(std::min(k_rows_at_once, count - first));
      in_blocks(rows_.size(), k_rows_per_task, [&](std::size_t begin, std::size_t end) {
        fill(first + begin, std::span(rows_).subspan(begin, end - begin));
      });
      output_->write(rows_);
    }
    written_ += count;
  }

  const CheckedQuery& request_;
  Listener& listener_;
  QueryOf<Target> query_;
  TargetReader<Target> reader_;
  TargetBatch<Target> batch_;
  // One of these two is queried.
  std::unique_ptr<CopcTiles> tiles_;
  std::optional<QueriedCloud> cloud_;
  std::function<std::uint64_t(std::uint64_t row)> point_ids_;  ///< empty: the rows
  std::unique_ptr<AnswerOutput> output_;
  std::vector<AnswerRow> rows_;  ///< that are written next
  std::uint64_t written_ = 0;
  QueryStatistics steps_;
  QueryResult result_;
};

/// Memory for each point of the clouds, as measured; 0: only a part of them is held.
double bytes_per_point(const CheckedQuery& query) {
  if (queries_in_place(query) || std::ranges::any_of(query.files.inputs, is_in_database)) return 0.0;
  const bool is_mapped = query.files.only(k_index_format) != nullptr;
  if (query.form == AnswerForm::las) return is_mapped ? 10.0 : 39.0;
  return is_mapped ? 6.0 : query.max_level ? 23.0 : 13.0;
}

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
  CheckedQuery query{given};
  query.family = chosen_family(query);
  check_fields(query);
  // The library's rays are whole lines, as the paper's.
  if (query.family == TargetFamily::rays && !query.t_min) query.t_min = 0.0;
  query.form = chosen_form(query);
  PlannedWork work{.clouds = query.files,
                   .partial = query.partial,
                   .reads = {query.given_targets().text},
                   .writes = {query.output},
                   .bytes_per_point = bytes_per_point(query),
                   .bytes_beside = 25e6};
  with_geometry(query.family, [&]<class Target>(std::type_identity<Target>) {
    (void)conditions<Target>(query);
    check_outputs(work, query.overwrite);
    check_first_targets<Target>(query);
  });
  if (query.memory && !queries_in_place(query))
    throw input_error("--memory requires a COPC query without --load",
                      "a single COPC file, or a catalog of such");
  if (query.max_level &&
      stored_organisation(query.files).value_or(Organisation::layered) != Organisation::layered) {
    throw file_error(query.files.first_name(), "--max-level requires a layered index",
                     "a layered index (alidade index --organisation layered)");
  }
  return {std::move(query), std::move(work)};
}

QueryResult run(const QueryPlan& plan, Listener& listener) {
  return with_geometry(plan.request().family, [&]<class Target>(std::type_identity<Target>) {
    return QueryRun<Target>(plan.request(), listener).run();
  });
}

}  // namespace alidade::jobs
