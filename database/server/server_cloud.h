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
#include "database/server/copy_format.h"
#include "database/server/server_connection.h"

namespace alidade::database {

/// A column of numbers of a table on a server, whoever made it.
struct NumberColumn {
  std::string name;
  /// int16, int32, int64, float32 or float64: what a COPY of expression() gives.
  ScalarType type = ScalarType::float64;
  bool is_decimal = false;  ///< numeric, which is read as float64
  bool can_be_null = false;

  bool is_whole() const { return type != ScalarType::float32 && type != ScalarType::float64; }

  /// What SQL calls its value.
  std::string expression() const;
};

/// A table that is a cloud: it has numbers x, y and z.
struct ServerTable {
  std::string quoted_name;            ///< "SCHEMA"."TABLE"
  std::vector<NumberColumn> columns;  ///< as the table has them
  std::vector<std::string> left_out;  ///< names of columns that are no numbers
  double row_estimate = 0.0;          ///< about how many rows; 0 if unknown
  std::optional<CloudRow> cloud{};    ///< of tables that `alidade sql load` made

  /// Null if there is none of that name.
  const NumberColumn* find(std::string_view name) const;

  /// Condition for rows with a position: x, y and z finite.
  std::string has_position() const;
};

/// Looks the table up, within the transaction that the connection is in. Errors: the name has no table; there
/// is no such table, or it lacks x, y or z; the row of NAME_cloud cannot be; the server's.
ServerTable find_server_table(ServerConnection& connection, const ServerName& name);

/// What a column of a table on a server becomes in a cloud.
struct ValueColumn {
  NumberColumn column;
  std::optional<Attribute> attribute{};  ///< none: an extra dimension
  std::size_t part = 0;                  ///< of the attribute, as red is of color
};

/// All columns but x, y, z: attributes whose parts (attribute_parts()) are all there, of whole numbers where
/// the attribute is; the others become extra dimensions. `id` is left out on demand.
std::vector<ValueColumn> value_columns(const ServerTable& table, bool without_id);

/// The attributes that they make.
AttributeSet attributes_of(std::span<const ValueColumn> columns);

/// Those of the wanted attributes.
std::vector<ValueColumn> kept_columns(std::span<const ValueColumn> columns, AttributeSet wanted);

/// The number of such a column; whole ones beyond 2^53 are rounded. Errors: a field of another size.
double number_of(const NumberColumn& column, CopyField field);
std::int64_t whole_of(const NumberColumn& column, CopyField field);

/// Puts rows into the columns of a cloud. NULL becomes 0 in attributes of whole numbers, NaN in others and in
/// extra dimensions of real numbers, the least number in those of whole ones, whose mark for "no value" it
/// is.
class CloudValues {
 public:
  /// Makes the columns, in a cloud that keeps its extra dimensions for good. The cloud must outlive it.
  CloudValues(PointCloud& cloud, std::vector<ValueColumn> columns);

  /// The cloud has other rows now.
  void find_columns();

  /// Fills a row with fields in the order of the columns. Errors: a value out of the attribute's range;
  /// location() is where, for the message.
  template <class Location>
  void put(std::size_t row, std::span<const CopyField> fields, const Location& location) {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (!put(targets_[i], row, fields[i])) reject(targets_[i], fields[i], location());
    }
  }

  /// How many NULLs became 0.
  std::uint64_t null_count() const { return null_count_; }

 private:
  struct Target {
    ValueColumn source;
    ScalarType type;            ///< in the cloud
    std::size_t dimension = 0;  ///< of extra dimensions
    std::byte* values = nullptr;
    std::size_t stride = 0;
    double most = 0.0;  ///< of whole attributes
  };
  bool put(const Target& target, std::size_t row, CopyField field);
  [[noreturn]] static void reject(const Target& target, CopyField field, std::string location);

  PointCloud& cloud_;
  std::vector<Target> targets_;
  std::uint64_t null_count_ = 0;
};

/// Which rows of a table are wanted, and what of them.
struct RowChoice {
  std::vector<ValueColumn> columns{};
  bool has_ids = false;     ///< the table has whole numbers id
  bool is_sorted = false;   ///< by them
  std::string condition{};  ///< beside ServerTable::has_position(); empty for none
};

/// A row, while it is shown.
struct ServerRow {
  std::uint64_t number = 0;  ///< of those that were shown
  std::int64_t id = 0;       ///< 0 without RowChoice::has_ids
  glm::dvec3 world{0.0};
  std::span<const CopyField> values{};  ///< of RowChoice::columns
};

/// A table of a server, open as a cloud: all that is read of it is of one moment.
class ServerCloud {
 public:
  /// Errors: ServerConnection's and find_server_table()'s.
  explicit ServerCloud(const ServerName& name);

  ServerConnection& connection() { return connection_; }
  const ServerConnection& connection() const { return connection_; }
  const ServerTable& table() const { return table_; }

  /// Shows rows. Errors: the server's; what it sends is no rows.
  void read(const RowChoice& choice, const std::function<void(const ServerRow&)>& take,
            const ServerWait& wait);

 private:
  static ServerTable begin(ServerConnection& connection, const ServerName& name);

  ServerConnection connection_;
  ServerTable table_;
};

}  // namespace alidade::database
