// SPDX-License-Identifier: MIT
#include "extensions/postgres/server_clouds.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"
#include "database/point_stream.h"
#include "database/sql/sql_tokens.h"
#include "extensions/postgres/copy_format.h"
#include "extensions/postgres/server_connection.h"
#include "extensions/postgres/server_sql.h"
#include "extensions/postgres/server_table.h"

namespace alidade::database {
namespace {

constexpr std::size_t k_most_filters = 64;

/// The condition for the server; empty if it would not help.
std::string condition(ServerConnection& connection, std::span<const PointFilter> any_of) {
  if (any_of.size() > k_most_filters) return {};
  // The schema of the functions need not be on the search path. Without the extension all rows are read.
  const ServerRows schema = connection.run(
      "SELECT quote_ident(n.nspname) FROM pg_catalog.pg_extension e"
      " JOIN pg_catalog.pg_namespace n ON n.oid = e.extnamespace WHERE e.extname = 'alidade_pg'");
  if (schema.size() == 0) return {};
  const std::string name = schema.text(0, 0);
  connection.run("SELECT set_config('search_path', current_setting('search_path') || ', ' || $1::text, true)",
                 std::span(&name, 1));
  return filter_condition(any_of);
}

constexpr const char* k_id = "id";

/// Order of the rows of a table in a cloud.
struct RowOrder {
  std::uint64_t count = 0;
  bool is_by_id = false;  ///< ids are 0, 1, ... each once: rows may come in any order within a piece
};

/// Copies rows into a cloud, piece by piece.
class RowPlacer {
 public:
  RowPlacer(ServerCloud& server, PointCloud& cloud, AttributeSet kept, std::vector<ValueColumn> columns,
            const RowOrder& order, const CloudPieces& pieces)
      : server_(server),
        cloud_(cloud),
        kept_(kept),
        values_(cloud, std::move(columns)),
        order_(order),
        pieces_(pieces),
        lattice_(server.table().cloud ? server.table().cloud->lattice : cloud.lattice),
        shift_(lattice_, cloud.lattice, server.connection().name()) {
    make_room();
  }

  /// Whether the first piece has room for all rows.
  bool is_one_piece() const { return room_ == order_.count; }

  void take(const ServerRow& row) {
    if (done_ == order_.count)
      server_.connection().fail("the server sent more rows than it counted", std::to_string(order_.count));
    if (done_ == first_ + room_) make_room();
    const std::uint64_t slot = order_.is_by_id ? slot_of(row) : done_ - first_;
    cloud_.positions[start_ + slot] = position_of(row);
    values_.put(start_ + slot, row.values, [&] {
      return order_.is_by_id ? fmt::format("id {}", row.id) : fmt::format("row {}", row.number + 1);
    });
    ++done_;
  }

  /// Errors: rows are missing.
  void finish() const {
    if (done_ != order_.count)
      server_.connection().fail("the server sent fewer rows than it counted", std::to_string(order_.count),
                                std::to_string(done_));
  }

  std::uint64_t done() const { return done_; }
  std::uint64_t null_count() const { return values_.null_count(); }

 private:
  void make_room() {
    first_ = done_;
    room_ = room_in_piece(cloud_, kept_, order_.count - done_, pieces_);
    start_ = cloud_.size();
    append_rows(cloud_, kept_, room_);
    values_.find_columns();
    is_there_.assign(order_.is_by_id ? room_ : 0, false);
  }

  /// The slot of a row in the piece, by its id.
  std::uint64_t slot_of(const ServerRow& row) {
    const std::uint64_t slot = static_cast<std::uint64_t>(row.id) - first_;
    if (slot >= room_ || is_there_[slot]) {
      server_.connection().fail("ids do not match the rows",
                                fmt::format("each id below {} once", order_.count), std::to_string(row.id));
    }
    is_there_[slot] = true;
    return slot;
  }

  LatticePosition position_of(const ServerRow& row) const {
    const std::optional<LatticePosition> position = to_lattice(lattice_, row.world);
    if (!position) {
      server_.connection().fail("a point lies outside the lattice", {},
                                fmt::format("{}, {}, {}", row.world.x, row.world.y, row.world.z));
    }
    return shift_(*position);
  }

  ServerCloud& server_;
  PointCloud& cloud_;
  AttributeSet kept_;
  CloudValues values_;
  RowOrder order_;
  const CloudPieces& pieces_;
  Lattice lattice_;
  LatticeShift shift_;
  std::uint64_t first_ = 0, done_ = 0;  ///< of the piece; rows in all
  std::size_t room_ = 0, start_ = 0;    ///< rows of the piece, the first one's in the cloud
  std::vector<bool> is_there_{};
};

class ServerCloudReader final : public CloudReader {
 public:
  explicit ServerCloudReader(const std::string& name) : server_(ServerName(name)) {
    facts_.file.path = server_.connection().name();
    facts_.file.format = "PostgreSQL";
    // Until the survey, ids are assumed to be row numbers.
    take_columns(has_whole_ids());
    facts_.work = work();
    if (!cloud_row()) return;
    facts_.file.version = std::to_string(k_cloud_row_version);
    facts_.file.point_count = cloud_row()->point_count;
    facts_.lattice = cloud_row()->lattice;
    facts_.point_count = cloud_row()->point_count;
    facts_.crs = cloud_row()->crs;
    facts_.gps_time_is_standard = cloud_row()->gps_time_is_standard;
    if (!cloud_row()->box.empty()) facts_.box = cloud_row()->box;
    if (!has_whole_ids()) server_.connection().fail("missing ids of the points", "an integer column id");
    ids_are_numbers_ = true;
  }

  CoordinateSurvey survey(const Progress& progress) override {
    const ServerTable& table = server_.table();
    const ServerWait wait = reporting(progress);
    const std::string filter = " FILTER (WHERE " + table.has_position() + ")";
    constexpr const char* k_axes[] = {"x", "y", "z"};
    std::string sql = "SELECT count(*), count(*)" + filter;
    for (const char* const axis : k_axes) {
      const std::string number = table.find(axis)->expression() + "::float8";
      sql += ", min(" + number + ")" + filter + ", max(" + number + ")" + filter;
    }
    const ServerRows found = server_.connection().run(sql + " FROM " + table.quoted_name, {}, wait);
    CoordinateSurvey survey;
    const auto rows = static_cast<std::uint64_t>(found.whole(0, 0));
    survey.finite_count = static_cast<std::uint64_t>(found.whole(0, 1));
    survey.dropped_count = rows - survey.finite_count;
    for (int axis = 0; axis < 3 && survey.finite_count > 0; ++axis) {
      survey.bounds.min[axis] = found.number(0, 2 + 2 * axis);
      survey.bounds.max[axis] = found.number(0, 3 + 2 * axis);
      survey.resolution[axis] =
          type_resolution(table.find(k_axes[axis])->type,
                          std::max(std::abs(survey.bounds.min[axis]), std::abs(survey.bounds.max[axis])));
    }
    ids_are_numbers_ = are_row_numbers(rows, wait);
    take_columns(ids_are_numbers_);
    survey_ = survey;
    report(progress, work(), work());
    return survey;
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    if (!cloud_row() && !survey_) survey({});
    const bool has_dropped = survey_ && survey_->dropped_count > 0;
    const RowOrder order{count_rows(reporting(progress)), ids_are_numbers_ && !has_dropped};
    const AttributeSet kept = facts_.attributes & wanted;
    RowChoice choice{.columns = kept_columns(columns_, kept), .has_ids = ids_are_numbers_};
    RowPlacer placer(server_, cloud, kept, choice.columns, order, pieces);
    // Rows that fit in one piece are sorted here, by their slots.
    choice.is_sorted = ids_are_numbers_ && !(order.is_by_id && placer.is_one_piece());

    const std::uint64_t all = work();
    const auto report_progress = [&] {
      const double share =
          static_cast<double>(placer.done()) / static_cast<double>(std::max<std::uint64_t>(order.count, 1));
      report(progress, static_cast<std::uint64_t>(share * static_cast<double>(all)), all);
    };
    server_.read(
        choice,
        [&](const ServerRow& row) {
          constexpr std::uint64_t k_rows_per_report = 1 << 14;
          if (row.number % k_rows_per_report == 0) report_progress();
          placer.take(row);
        },
        report_progress);
    placer.finish();
    const std::uint64_t dropped = survey_ ? survey_->dropped_count : 0;
    warn(cloud, dropped, placer.null_count());
    report(progress, all, all);
    return read_rows(order.count, dropped);
  }

 private:
  void take_columns(bool ids_are_numbers) {
    columns_ = value_columns(server_.table(), ids_are_numbers);
    facts_.attributes = attributes_of(columns_);
  }

  /// Bytes to be transferred, about.
  std::uint64_t work() const {
    constexpr double k_least_rows = 1.0, k_most_rows = 1e12;
    const double rows =
        cloud_row() ? static_cast<double>(cloud_row()->point_count) : server_.table().row_estimate;
    const std::size_t bytes_of_row = 12 * (4 + columns_.size());
    return static_cast<std::uint64_t>(std::clamp(rows, k_least_rows, k_most_rows)) * bytes_of_row;
  }

  const std::optional<CloudRow>& cloud_row() const { return server_.table().cloud; }
  bool has_whole_ids() const {
    const NumberColumn* const id = server_.table().find(k_id);
    return id != nullptr && id->is_whole();
  }
  ServerWait reporting(const Progress& progress) const {
    return [this, &progress] { report(progress, 0, work()); };
  }

  /// For tables without NAME_cloud: whether ids are 0, 1, ... each once.
  bool are_row_numbers(std::uint64_t rows, const ServerWait& wait) {
    if (!has_whole_ids() || rows == 0) return false;
    const std::string from = " FROM " + server_.table().quoted_name;
    const auto last = static_cast<std::int64_t>(rows - 1);
    const ServerRows range = server_.connection().run("SELECT min(id), max(id), count(id)" + from, {}, wait);
    if (range.is_null(0, 0) || range.whole(0, 0) != 0 || range.whole(0, 1) != last ||
        range.whole(0, 2) != last + 1)
      return false;
    return server_.connection().run("SELECT count(DISTINCT id)" + from, {}, wait).whole(0, 0) == last + 1;
  }

  /// Memory is taken for the number of rows in NAME_cloud only if the table has so many.
  std::uint64_t count_rows(const ServerWait& wait) {
    if (!cloud_row()) return survey_->finite_count;
    const ServerTable& table = server_.table();
    const ServerRows found = server_.connection().run(
        "SELECT count(*) FROM " + table.quoted_name + " WHERE " + table.has_position(), {}, wait);
    const auto count = static_cast<std::uint64_t>(found.whole(0, 0));
    if (count != cloud_row()->point_count) {
      server_.connection().fail("the number of points differs from NAME_cloud",
                                std::to_string(cloud_row()->point_count), std::to_string(count));
    }
    return count;
  }

  void warn(PointCloud& cloud, std::uint64_t dropped, std::uint64_t null_count) const {
    const auto say = [&](const std::string& clause) {
      cloud.warnings.push_back(server_.connection().name() + ": " + clause);
    };
    if (dropped > 0) say(fmt::format("skipped {} points without finite coordinates", dropped));
    if (null_count > 0) say(fmt::format("{} NULLs in attribute columns were read as 0", null_count));
    const std::vector<std::string>& left_out = server_.table().left_out;
    if (!left_out.empty())
      say(fmt::format("skipped columns that are not numeric: {}", fmt::join(left_out, ", ")));
  }

  ServerCloud server_;
  bool ids_are_numbers_ = false;
  std::vector<ValueColumn> columns_{};
  std::optional<CoordinateSurvey> survey_{};
};

/// The quoted names of the objects of a cloud.
struct CloudTables {
  std::string schema, points, cloud;
};

bool has_relation(ServerConnection& connection, const std::string& schema, const std::string& name) {
  const std::array<std::string, 2> names = {schema, name};
  const ServerRows found = connection.run(
      "SELECT 1 FROM pg_catalog.pg_class c JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace"
      " WHERE n.nspname::text = $1::text AND c.relname::text = $2::text",
      names);
  return found.size() > 0;
}

/// Errors: an object of such a name exists that must not be replaced.
CloudTables check_tables(ServerConnection& connection, const ServerName& name, bool replace) {
  std::string schema = name.schema;
  if (schema.empty()) schema = connection.run("SELECT current_schema()").text(0, 0);
  if (schema.empty()) connection.fail("empty search path", "one in the name, as &schema=public");
  const bool has_points = has_relation(connection, schema, name.table);
  const bool has_cloud = has_relation(connection, schema, name.table + "_cloud");
  if (has_points && !(replace && has_cloud)) {
    connection.fail(
        fmt::format("the table {} exists", name.table),
        replace ? "a cloud with the table " + name.table + "_cloud" : "another name, or --overwrite");
  }
  if (has_cloud && !has_points)
    connection.fail(fmt::format("the table {}_cloud exists", name.table), "another name");
  return {.schema = schema,
          .points = sql_name(schema) + "." + sql_name(name.table),
          .cloud = sql_name(schema) + "." + sql_name(name.table + "_cloud")};
}

}  // namespace

bool has_server_parts(const std::string& name) {
  return ServerCloud(ServerName(name)).table().cloud.has_value();
}

CloudPart read_server_part(const std::string& name, std::span<const PointFilter> any_of,
                           AttributeSet attributes, const Progress& progress) {
  ServerCloud server((ServerName(name)));
  const CloudRow& row_of_cloud = server.table().cloud.value();
  const std::vector<ValueColumn> columns = value_columns(server.table(), true);
  CloudPart part;
  part.attributes = attributes_of(columns);
  const AttributeSet kept = part.attributes & attributes;
  part.cloud.lattice = row_of_cloud.lattice;
  part.cloud.crs = row_of_cloud.crs;
  part.cloud.gps_time_is_standard = row_of_cloud.gps_time_is_standard;
  const RowChoice choice{.columns = kept_columns(columns, kept),
                         .has_ids = true,
                         .is_sorted = true,
                         .condition = condition(server.connection(), any_of)};
  CloudValues values(part.cloud, choice.columns);
  const ServerWait wait = [&] {
    report(progress, part.ids.size(), std::max<std::uint64_t>(row_of_cloud.point_count, 1));
  };
  server.read(
      choice,
      [&](const ServerRow& row) {
        const auto id = static_cast<std::uint64_t>(row.id);
        if (id >= row_of_cloud.point_count || (!part.ids.empty() && id <= part.ids.back())) {
          server.connection().fail("ids do not match the rows",
                                   fmt::format("each id below {} once", row_of_cloud.point_count),
                                   std::to_string(row.id));
        }
        const auto position = to_lattice(row_of_cloud.lattice, row.world);
        if (!position)
          server.connection().fail("a point lies outside the lattice", {}, {}, fmt::format("id {}", id));
        const std::size_t index = part.ids.size();
        if (index == part.cloud.size()) {
          append_rows(part.cloud, kept, std::max<std::size_t>(index, 4096));
          values.find_columns();
          wait();
        }
        part.ids.push_back(id);
        part.cloud.positions[index] = *position;
        values.put(index, row.values, [&] { return fmt::format("id {}", id); });
      },
      wait);
  part.cloud.resize(part.ids.size());
  report(progress, part.ids.size(), part.ids.size());
  CloudFile& file = part.cloud.files.emplace_back();
  file.path = server.connection().name();
  file.format = "PostgreSQL";
  file.version = std::to_string(k_cloud_row_version);
  file.point_count = part.ids.size();
  return part;
}

const CloudFormat k_server_format{.name = "PostgreSQL",
                                  .is_named = is_server_name,
                                  .open = [](InputFile input, Damage) -> std::unique_ptr<CloudReader> {
                                    return std::make_unique<ServerCloudReader>(input.name());
                                  }};

ServerStore::ServerStore(const ServerName& name, bool replace) : name_(name), replace_(replace) {
  if (name.table.empty()) throw file_error(name.shown(), "missing table name", "?table=NAME at the end");
  check_server_table(name.table);
  connection_ = std::make_unique<ServerConnection>(name);
  check_tables(*connection_, name, replace);
}

ServerStore::~ServerStore() = default;

void ServerStore::store(OrderedCloud& cloud, const Progress& progress) {
  std::uint64_t done = 0;
  const ServerWait wait = [&] { report(progress, done, cloud.points.size()); };
  connection_->run("BEGIN");
  const CopyRows rows(cloud.columns(), cloud.whole.rest.lattice);
  check_column_count(rows.columns());
  connection_->run("CREATE EXTENSION IF NOT EXISTS alidade_pg");
  // Another session may have made a table meanwhile.
  const CloudTables tables = check_tables(*connection_, name_, replace_);
  if (replace_) connection_->run("DROP TABLE IF EXISTS " + tables.points + ", " + tables.cloud, {}, wait);
  connection_->run("CREATE TABLE " + tables.points + "(" + server_columns(rows.columns()) +
                   ", CONSTRAINT has_place CHECK (x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND"
                   " y < 'Infinity' AND z > '-Infinity' AND z < 'Infinity'))");
  connection_->begin_copy_in("COPY " + tables.points + " FROM STDIN (FORMAT binary)");
  const Bounds box =
      rows.copy(cloud, cloud.points.size(), [&](std::span<const std::byte> bytes, std::size_t count) {
        connection_->put(bytes, wait);
        done += count;
        wait();
      });
  connection_->end_copy_in(wait);
  connection_->run(server_index(tables.points), {}, wait);
  connection_->run(cloud_row_table(tables.cloud));
  connection_->run(cloud_row_insert(tables.cloud, cloud_row(cloud.whole, box)));
  connection_->run("ANALYZE " + tables.points, {}, wait);
  connection_->run("COMMIT", {}, wait);
}

}  // namespace alidade::database
