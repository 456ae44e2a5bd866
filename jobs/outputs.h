// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace alidade::jobs {

/// Lets a long task fail before it starts: Error if the file is one of `inputs` by whatever name ("-" is
/// standard input; empty ones are skipped), exists and may not be replaced, is no regular file, or if its
/// folder cannot be written to.
void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs = {});

/// Errors: a file's name ends in none of these, given in lower case as ".las"; its own case is ignored.
void check_extension(const std::filesystem::path& file, const std::vector<std::string>& extensions);

/// check_writable() for all files that a job or command writes; empty names are left out. Errors: two of them
/// are one file, or one is among `others`, outputs that are checked elsewhere.
void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs = {},
                   std::span<const std::filesystem::path> others = {});

/// Whether two names are those of one file, which need not exist.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// A file's name for metadata, which other people read: the last part of an absolute path, public_name() of a
/// URL, other names as they are.
std::string kept_name(const std::filesystem::path& given);

}  // namespace alidade::jobs
