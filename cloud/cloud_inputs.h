// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_reader.h"

namespace alidade {

/// The files that names of files, folders and patterns stand for, in the order of the names:
/// - the name of a cloud in a database (cloud_database.h) stands for itself;
/// - what is neither a folder nor a pattern is one file, whether it is there or not;
/// - a folder is the cloud files in it, not those of folders inside it: what ends in las, laz, ply, pcd, e57,
///   pts, ptx, xyz, txt or csv, in capitals or not;
/// - a pattern is what it matches: * any letters but '/', ? one letter, [a-c] one of these, [!a-c] one that
///   is not, in the name of the file or of folders above it. If the name's last part has no '.', only cloud
///   files are taken, as from a folder. If it is no pattern, it may be a folder, and stands for its files.
/// A name that is there is taken as it stands, whatever letters are in it, and so are names of folders in a
/// pattern. Hidden files (.name) and index files (.alidade) are left out unless named: by the first letters,
/// or the ending, of the pattern. Links are what they lead to; one that leads nowhere is a file, which cannot
/// be opened, as nobody shall miss it. The files of one name are sorted by the bytes of their paths; a file
/// that two names stand for comes twice.
///
/// Errors: a folder without cloud files or that cannot be read; a pattern that matches none. Each says what
/// was looked for. Cost: one look into each folder concerned.
std::vector<std::filesystem::path> expand_cloud_files(std::span<const std::filesystem::path> names);

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
