// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"
#include "database/point_stream.h"
#include "jobs/fields.h"

// The formats that jobs read and write: those of files, index files, SQLite, and what extensions add.

namespace alidade::jobs {

/// An output of 'convert' or 'sql load'.
struct StoreTarget {
  std::filesystem::path output;
  std::string table{};  ///< name of the cloud in a database; empty: its default
  bool overwrite = false;
};

/// An output that takes a cloud whose points are sorted.
struct OpenStore {
  std::filesystem::path folder;  ///< for points that memory does not hold
  /// Stores the cloud; `progress` is in points.
  std::function<void(database::OrderedCloud& cloud, const Progress& progress)> store;
};

/// A kind of outputs that an extension adds, with its settings of one request.
class CloudStore {
 public:
  virtual ~CloudStore() = default;

  /// How its outputs are named: ".parquet", a file's extension, for 'convert', or a form for 'sql load'.
  virtual std::string form() const = 0;
  bool is_file() const { return form().starts_with('.'); }
  virtual bool is_named(const std::filesystem::path& output) const = 0;
  virtual void add_fields(const Fields&) {}
  /// The problem if the output is another one: a setting that only this kind has was given; empty: none.
  virtual std::string misplaced() const { return {}; }

  /// Checks all that needs no point, and returns the output's name for messages.
  virtual std::string check(const StoreTarget& target) const = 0;
  /// As check(), but opens the output. Errors: also those of opening it.
  virtual OpenStore open(const StoreTarget& target) const = 0;
};

using CloudStores = std::vector<std::shared_ptr<CloudStore>>;

/// A format beside those of file_formats() and index files.
struct AddedFormat {
  /// A line of 'alidade formats'.
  struct Facts {
    const char *name, *extensions, *versions, *use, *remarks;
  };
  Facts facts;

  // Of a format that is read:
  const CloudFormat* format = nullptr;
  /// For clouds on servers: a name that denotes one of them, without what no message may repeat. Errors: it
  /// is invalid.
  std::string (*shown)(const std::string& name) = nullptr;
  // Of databases:
  const char* part_unit = "";  ///< of the progress of read_part()
  bool (*has_parts)(const std::string& name) = nullptr;
  /// Reads those points that are needed: at least all for which a filter holds. Null: not a database.
  database::CloudPart (*read_part)(const std::string& name, std::span<const database::PointFilter> any_of,
                                   AttributeSet attributes, const Progress& progress) = nullptr;

  /// Makes an output; null: clouds are not stored by it.
  std::shared_ptr<CloudStore> (*make_store)() = nullptr;
};

/// Adds a format, tested before all others. Only before the first other call of these functions.
void add_format(const AddedFormat& format);

/// SQLite, and what was added.
std::span<const AddedFormat> added_formats();

/// All formats that jobs read: added ones, index files, and those of files.
CloudFormats cloud_formats();

/// One of each kind, with default settings.
CloudStores make_stores();

/// The one of files, or of databases, that the output's name selects; null: none does.
const CloudStore* store_of(const CloudStores& stores, const std::filesystem::path& output, bool is_file);

/// The format of clouds on servers that have such names; null: it denotes a file or SQLite's cloud.
const AddedFormat* server_of(const std::string& name);

bool is_in_database(const CloudInput& input);

/// Whether a part of a cloud can be read from its database: 'alidade sql load' has stored it, and no field
/// changes its points. Errors: those of opening a table on a server.
bool has_parts(const CloudInput& input);

/// The unit of parts of a cloud in a database: "chunks" of SQLite, "points" of a server.
const char* part_unit(const CloudInput& input);

/// AddedFormat::read_part() of a cloud. Requires has_parts(input).
database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress);

}  // namespace alidade::jobs
