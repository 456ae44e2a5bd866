// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "cloud/cloud_reader.h"

namespace alidade {

/// Clouds that lie in databases. The library opens none itself; a program says how, before it reads clouds.
struct CloudDatabase {
  bool (*is_named)(const std::string& name);                      ///< names that are no files
  bool (*is_begun_by)(const std::string& bytes);                  ///< files, by at least their first 16 bytes
  std::unique_ptr<CloudReader> (*open)(const std::string& name);  ///< of either kind
};

/// Has clouds read from such databases, too. Not while clouds are being read.
void add_cloud_database(const CloudDatabase& database);

/// The one whose cloud is named so; null for names of files.
const CloudDatabase* find_database_named(const std::string& name);

/// The one whose file begins so; null if there is none.
const CloudDatabase* find_database_begun_by(const std::string& bytes);

/// Whether the cloud of that name lies in a database, whose first bytes are looked at if it is a file that is
/// there.
bool lies_in_database(const std::filesystem::path& name);

/// The file of that name, or what stands for a cloud of that name in a database: open_cloud() knows it again.
/// Errors: InputFile's.
InputFile cloud_input(const std::filesystem::path& name);

}  // namespace alidade
