// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "cloud/cloud_inputs.h"
#include "jobs/cloud_fields.h"
#include "jobs/fields.h"
#include "jobs/long_run.h"
#include "jobs/outputs.h"
#include "tools/console.h"
#include "tools/manual_page.h"

// The command line: commands, whose options are fields (jobs/fields.h), and options that several commands
// share. The parser is CLI11, which only options.cpp includes: it takes longer to compile than most commands.

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace alidade::tools {

using jobs::add_checkpoint_fields;
using jobs::add_cloud;
using jobs::add_cloud_files;
using jobs::add_partial;
using jobs::add_view_fields;
using jobs::check_outputs;
using jobs::check_writable;
using jobs::CheckpointRequest;
using jobs::CloudView;
using jobs::Field;
using jobs::Fields;
using jobs::HeightUse;
using jobs::ImageSize;
using jobs::k_files_help;
using jobs::parse_classes;
using jobs::parse_count;
using jobs::parse_image_size;
using jobs::parse_length_limit;
using jobs::parse_limit;
using jobs::parse_memory;
using jobs::parse_moment;
using jobs::parse_number;
using jobs::parse_size;
using jobs::same_file;
using jobs::split_list;
using jobs::UsageError;

/// The part of a command's manual behind its options: the text of NAME.txt in tools/manuals, or in the folder
/// of an extension, which is compiled into the program. `name`: "query", or "visibility_raster" for a command
/// of a group; "alidade" for the program. Requires: there is such a text.
std::string_view manual(std::string_view name);

/// The options of a command. Copies refer to the same command.
class Options : public Fields {
 public:
  /// Declares a sub-command, whose manual is NAME.txt, or GROUP_NAME.txt for one of a group.
  Options command(const std::string& name, const std::string& description) const;

  /// A second name of the command.
  Options also_called(const std::string& name) const;

  /// Makes one of the sub-commands required.
  Options require_command() const;

  /// Replaces the end of the manual, for a text that is partly computed.
  void manual(const std::string& text) const;

  /// Whether a word is a name of the command.
  bool is_called(const std::string& word) const;

  /// Whether this command is on the command line.
  bool chosen() const;

  /// The command as its manual describes it.
  CommandEntry entry() const;

  /// "--radius" and so on: all long names.
  std::vector<std::string> long_names() const;

 private:
  friend class Parser;
  explicit Options(CLI::App* app);

  CLI::App* app_;
};

/// Reads a command line into what its commands declared.
class Parser {
 public:
  enum class Action { work, help, version };

  Parser();
  ~Parser();

  /// The program itself, which requires one of its commands.
  Options program() const;

  /// Reads the words behind the program's name. Errors: UsageError.
  Action parse(std::span<const std::string> words);

  /// The help text of the command that --help follows.
  std::string help() const;

 private:
  std::unique_ptr<CLI::App> app_;
};

/// -q and -v.
void add_verbosity(const Fields& command, Verbosity& verbosity);

inline constexpr int k_most_threads = 1024;
/// --threads N; empty = as many as the machine has, or enough_threads() (tools/command.h).
void add_threads(const Fields& command, std::optional<int>& threads);

/// jobs::checkpoint_warning() for commands that are no jobs yet.
std::function<void(const Error&)> checkpoint_warning();

/// The words the program was started with, as they go into the metadata of what it writes.
using CommandLine = std::vector<std::string>;

/// How a command is to be run, whatever it does.
struct RunRequest {
  std::optional<int> threads;  ///< empty: all of the machine
  Verbosity verbosity = Verbosity::normal;
  CommandLine words;  ///< of the program, filled by command_of() when it runs
};

}  // namespace alidade::tools
