// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "tools/console.h"

// Options that several commands share, and the strict reading of their values. A value with anything behind
// the number is an error, as is one outside its limits; both are CLI::ValidationError naming the option.

namespace alidade::tools {

/// "2000000", "2e6", "1.5e3": a whole number in [least, most].
std::uint64_t parse_count(const std::string& text, std::uint64_t least, std::uint64_t most);

/// A finite number in [least, most].
double parse_number(const std::string& text, double least = std::numeric_limits<double>::lowest(),
                    double most = std::numeric_limits<double>::max());

/// A place on a scale: a number, inf or -inf.
double parse_limit(const std::string& text);

/// A length, at least 0; empty for inf, which is no limit.
std::optional<double> parse_length_limit(const std::string& text);

/// "600x400": width and height in pixels, each in [1, 65536].
struct ImageSize {
  int width = 0, height = 0;
};
ImageSize parse_image_size(const std::string& text);

/// Declares an option whose text `take` reads; `kind` stands behind the option's name in the help text.
CLI::Option* add_value(CLI::App& command, const std::string& names, const std::string& kind,
                       const std::string& help, std::function<void(const std::string&)> take);

/// Declares an option that takes one of the named values.
template <typename Value>
CLI::Option* add_choice(CLI::App& command, const std::string& names, const std::string& help,
                        std::optional<Value>& target, std::vector<std::pair<std::string, Value>> values) {
  std::string kind;
  for (const auto& value : values) kind += (kind.empty() ? "" : "|") + value.first;
  return add_value(command, names, kind, help, [&target, kind, values](const std::string& text) {
    for (const auto& [word, value] : values) {
      if (text == word) {
        target = value;
        return;
      }
    }
    throw CLI::ValidationError("expected " + kind + ", found '" + text + "'");
  });
}

/// -q and -v.
struct VerbosityOptions {
  bool quiet = false, verbose = false;
  Verbosity verbosity() const {
    return quiet ? Verbosity::quiet : verbose ? Verbosity::verbose : Verbosity::normal;
  }
};
void add_verbosity(CLI::App& command, VerbosityOptions& options);

/// --threads N; empty = as many as the machine has.
void add_threads(CLI::App& command, std::optional<int>& threads);

/// Runs `work` on exactly this many threads.
void with_threads(std::optional<int> threads, const std::function<void()>& work);

/// Lets a long task fail before it starts: Error if the file is one of `inputs` by whatever name ("-" is
/// standard input), exists and may not be replaced, is no regular file, or if its folder cannot be written
/// to.
void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs = {});

/// check_writable() for all files that a command writes; empty names are left out. Errors: two are the same.
void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs = {});

/// Whether two names are those of one file, which need not exist.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// What the help text says about the files of a cloud, where there is nothing else to say.
inline constexpr const char* k_cloud_help =
    "cloud files, folders or patterns as 'tiles/*.las', taken together as one, an index file (.alidade), or "
    "a "
    "table of a database: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// What other help texts about them end with.
inline const std::string k_database_help =
    "; a table of a database, too: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// Declares the option, or the operand, that takes the files of a cloud; folders and patterns are expanded
/// (resolve_clouds()) while the command line is read. Errors then: those of resolve_clouds().
CLI::Option* add_cloud_files(CLI::App& command, const std::string& name, CloudInputs& clouds,
                             const std::string& help);

/// Declares --partial.
CLI::Option* add_partial(CLI::App& command, bool& partial);

/// What stands between the commas of a text, one word at least.
inline std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    if (end == text.size()) return words;
    begin = end + 1;
  }
}

/// "800000000", "512M", "2G": bytes. Errors: CLI::ValidationError.
std::size_t parse_size(const std::string& text);

}  // namespace alidade::tools
