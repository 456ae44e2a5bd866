// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/point_cloud.h"
#include "extensions/postgres/copy_format.h"
#include "extensions/postgres/server_connection.h"

namespace alidade::database {

/// A column of numbers of any table on a server.
struct NumberColumn {
  std::string name;
  /// The type of expression() in a COPY: int16, int32, int64, float32 or float64.
  ScalarType type = ScalarType::float64;
  bool is_decimal = false;  ///< numeric, which is read as float64
  bool can_be_null = false;

  bool is_whole() const { return type != ScalarType::float32 && type != ScalarType::float64; }

  /// The expression of its value in SQL.
  std::string expression() const;
};

/// A table that is a cloud: it has columns of numbers x, y and z.
struct ServerTable {
  std::string quoted_name;            ///< "SCHEMA"."TABLE"
  std::vector<NumberColumn> columns;  ///< in the order of the table
  std::vector<std::string> left_out;  ///< names of columns that are not numbers
  double row_estimate = 0.0;          ///< about how many rows; 0 if unknown
  std::optional<CloudRow> cloud{};    ///< for tables that `alidade sql load` made

  /// The column of a name; null without such a column.
  const NumberColumn* find(std::string_view name) const;

  /// Condition for rows with a position: x, y and z finite.
  std::string has_position() const;
};

/// Finds the table, within the current transaction of the connection. Errors: the name has no table; there
/// is no such table, or it lacks x, y or z; the row of NAME_cloud is invalid; the server's.
ServerTable find_server_table(ServerConnection& connection, const ServerName& name);

/// The column of a cloud that a column of a table on a server becomes.
struct ValueColumn {
  NumberColumn column;
  std::optional<Attribute> attribute{};  ///< empty: an extra dimension
  std::size_t part = 0;                  ///< of the attribute, as red is of color
};

/// All columns but x, y, z: attributes if all of their parts (attribute_parts()) exist, as integers if
/// the attribute is one; the others become extra dimensions. `id` is left out on demand.
std::vector<ValueColumn> value_columns(const ServerTable& table, bool without_id);

/// The attributes of these columns.
AttributeSet attributes_of(std::span<const ValueColumn> columns);

/// The columns of the wanted attributes.
std::vector<ValueColumn> kept_columns(std::span<const ValueColumn> columns, AttributeSet wanted);

/// The number in a field of such a column; integers beyond 2^53 are rounded. Errors: a field of another size.
double number_of(const NumberColumn& column, CopyField field);
std::int64_t whole_of(const NumberColumn& column, CopyField field);

/// Copies rows into the columns of a cloud. NULL becomes 0 in integer attributes, NaN in others and in extra
/// dimensions of real numbers, and in those of integers the least number, which marks missing values.
class CloudValues {
 public:
  /// Adds the columns to the cloud, whose extra dimensions must not change later. The cloud must outlive it.
  CloudValues(PointCloud& cloud, std::vector<ValueColumn> columns);

  /// Must be called after the number of rows has changed.
  void find_columns();

  /// Fills a row with fields in the order of the columns. Errors: a value out of the attribute's range, with
  /// location() in the message.
  template <class Location>
  void put(std::size_t row, std::span<const CopyField> fields, const Location& location) {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (!put(targets_[i], row, fields[i])) reject(targets_[i], fields[i], location());
    }
  }

  /// Number of NULLs that became 0.
  std::uint64_t null_count() const { return null_count_; }

 private:
  struct Target {
    ValueColumn source;
    ScalarType type;            ///< in the cloud
    std::size_t dimension = 0;  ///< of extra dimensions
    std::byte* values = nullptr;
    std::size_t stride = 0;
    double most = 0.0;  ///< of integer attributes
  };
  bool put(const Target& target, std::size_t row, CopyField field);
  [[noreturn]] static void reject(const Target& target, CopyField field, std::string location);

  PointCloud& cloud_;
  std::vector<Target> targets_;
  std::uint64_t null_count_ = 0;
};

/// The rows and columns of a table to read.
struct RowChoice {
  std::vector<ValueColumn> columns{};
  bool has_ids = false;     ///< the table has a column of integers id
  bool is_sorted = false;   ///< by id
  std::string condition{};  ///< beside ServerTable::has_position(); empty for none
};

/// A row, valid during the call that gets it.
struct ServerRow {
  std::uint64_t number = 0;  ///< of the rows read, from 0
  std::int64_t id = 0;       ///< 0 without RowChoice::has_ids
  glm::dvec3 world{0.0};
  std::span<const CopyField> values{};  ///< of RowChoice::columns
};

/// A table of a server, open as a cloud: everything is read from one snapshot.
class ServerCloud {
 public:
  /// Errors: ServerConnection's and find_server_table()'s.
  explicit ServerCloud(const ServerName& name);

  ServerConnection& connection() { return connection_; }
  const ServerConnection& connection() const { return connection_; }
  const ServerTable& table() const { return table_; }

  /// Reads rows. Errors: the server's; invalid data.
  void read(const RowChoice& choice, const std::function<void(const ServerRow&)>& take,
            const ServerWait& wait);

 private:
  static ServerTable begin(ServerConnection& connection, const ServerName& name);

  ServerConnection connection_;
  ServerTable table_;
};

}  // namespace alidade::database
