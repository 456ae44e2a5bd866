// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace alidade::compare {

/// Two images of a batch.
struct ImagePair {
  std::string name;                       ///< for people: the path inside the folders, or the third column
  std::filesystem::path reference, test;  ///< empty: the other one has no counterpart
};

/// The images of two folders and of the folders in them, recognised by their extension, paired by path and
/// name; by name without extension where that is unique on each side. By name, '/' as in paths. Images
/// without a counterpart are pairs with one side empty. Errors: no folder, nothing to compare, an unreadable
/// folder.
std::vector<ImagePair> pairs_of_folders(const std::filesystem::path& reference,
                                        const std::filesystem::path& test);

/// Pairs in the order of a CSV file with the header `reference,test` or `reference,test,name`; fields may
/// are in double quotes (doubled inside). Relative paths begin at the folder of the file; a missing name is
/// that of the test. Errors name the line: another header, another number of fields, an empty path, a quote
/// without end.
std::vector<ImagePair> read_pairs(const std::filesystem::path& file);
/// Reads the pairs from a stream with the text of `file`.
std::vector<ImagePair> read_pairs(std::istream& stream, const std::filesystem::path& file);

}  // namespace alidade::compare
