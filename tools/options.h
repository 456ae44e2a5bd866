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

#include "base/date_time.h"
#include "base/error.h"
#include "cloud/cloud_inputs.h"
#include "tools/console.h"
#include "tools/manual_page.h"

// The command line: declaring commands and options, options that several commands share, and the strict
// reading of their values. A value with anything behind the number is an error, as is one outside its limits.
// The parser is CLI11, which only options.cpp includes: it takes longer to compile than most commands.

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace alidade::tools {

struct ViewRequest;

/// A wrong value or use of an option; the message names the option.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "2000000", "2e6", "1.5e3": a whole number in [least, most].
std::uint64_t parse_count(const std::string& text, std::uint64_t least, std::uint64_t most);

/// A finite number in [least, most].
double parse_number(const std::string& text, double least = std::numeric_limits<double>::lowest(),
                    double most = std::numeric_limits<double>::max());

/// A position on a scale: a number, inf or -inf.
double parse_limit(const std::string& text);

/// A length, at least 0; empty for inf, which is no limit.
std::optional<double> parse_length_limit(const std::string& text);

/// A length, at least 0; infinity for inf.
double parse_distance_limit(const std::string& text);

/// "600x400": width and height in pixels, each in [1, 65536].
struct ImageSize {
  int width = 0, height = 0;
};
ImageSize parse_image_size(const std::string& text);

template <class Target>
struct OptionalValue {
  using type = Target;
};
template <class Value>
struct OptionalValue<std::optional<Value>> {
  using type = Value;
};

/// The type that an option stores: Value, for a target that is a Value or an optional Value.
template <class Target>
using ValueOf = typename OptionalValue<Target>::type;

/// An option or operand of a command. Copies refer to the same one.
class Option {
 public:
  void needs(const Option& other) const;
  /// Whether it is on the command line.
  bool given() const;

 private:
  friend class Options;
  explicit Option(CLI::Option* option) : option_(option) {}

  CLI::Option* option_;
};

/// The part of a command's manual behind its options: the text of tools/manuals/NAME.txt, which is compiled
/// into the program. `name`: "query", or "visibility_raster" for a command of a group; "alidade" for the
/// program. Requires: there is such a text.
std::string_view manual(std::string_view name);

/// The options of a command, or those under one heading of its manual. Copies refer to the same command.
/// `names` are as "-o,--output", or a word without hyphens for an operand; `kind` follows them in the manual,
/// as FILE. Values are stored in `target`, which must live as long as the program parses; a function that
/// reads a value throws UsageError without the option's name.
class Options {
 public:
  using Take = std::function<void(const std::string&)>;

  /// This command under another heading: options declared through the returned object are listed there.
  Options group(const std::string& heading) const;

  /// This command and heading: options declared through the returned object are required, need `other`, or
  /// exclude `other` and are excluded by it.
  Options required() const;
  Options needs(const Option& other) const;
  Options excludes(const Option& other) const;

  /// Declares a sub-command, whose manual is tools/manuals/NAME.txt, or GROUP_NAME.txt for one of a group.
  Options command(const std::string& name, const std::string& description) const;

  /// A second name of the command.
  Options also_called(const std::string& name) const;

  /// Makes one of the sub-commands required.
  Options require_command() const;

  /// Replaces the end of the manual, for a text that is partly computed.
  void manual(const std::string& text) const;

  /// An option with a value. Given more than once, its last value holds.
  Option value(const std::string& names, const std::string& kind, const std::string& help, Take take) const;

  /// An option whose value is what `parse` makes of the text.
  template <class Target, class Parse>
  Option value(const std::string& names, const std::string& kind, const std::string& help, Target& target,
               Parse parse) const {
    return value(names, kind, help, [&target, parse](const std::string& text) { target = parse(text); });
  }

  /// A repeatable option: every value is read.
  Option values(const std::string& names, const std::string& kind, const std::string& help, Take take) const;

  /// An option, or an operand, with at least so many words behind it; all are read at once.
  Option words(const std::string& names, const std::string& kind, const std::string& help,
               std::function<void(const std::vector<std::string>&)> take, int least = 1) const;

  /// Text as it is: one of it, or one per use.
  Option text(const std::string& names, const std::string& kind, const std::string& help,
              std::string& target) const;
  Option text(const std::string& names, const std::string& kind, const std::string& help,
              std::vector<std::string>& target) const;

  /// The name of a file or folder, once.
  Option file(const std::string& names, const std::string& kind, const std::string& help,
              std::filesystem::path& target) const;

  Option flag(const std::string& names, const std::string& help, bool& target) const;
  Option flag(const std::string& names, const std::string& help, std::function<void()> take) const;

  /// A number in [least, most], as parse_number() reads it.
  template <class Target>
  Option number(const std::string& names, const std::string& kind, const std::string& help, Target& target,
                double least = std::numeric_limits<double>::lowest(),
                double most = std::numeric_limits<double>::max()) const {
    return value(names, kind, help, [&target, least, most](const std::string& text) {
      target = parse_number(text, least, most);
    });
  }

  /// A length above 0.
  template <class Target>
  Option length(const std::string& names, const std::string& kind, const std::string& help,
                Target& target) const {
    return value(names, kind, help, [&target](const std::string& text) {
      const double number = parse_number(text, 0.0);
      if (number == 0.0) throw UsageError("invalid value; expected a positive length, found '0'");
      target = number;
    });
  }

  /// A whole number in [least, most], as parse_count() reads it, into an integer or an optional one.
  template <class Target>
  Option count(const std::string& names, const std::string& kind, const std::string& help, Target& target,
               std::uint64_t least, std::uint64_t most) const {
    return value(names, kind, help, [&target, least, most](const std::string& text) {
      target = static_cast<ValueOf<Target>>(parse_count(text, least, most));
    });
  }

  /// One of the named values.
  template <class Target>
  Option choice(const std::string& names, const std::string& help, Target& target,
                std::vector<std::pair<std::string, ValueOf<Target>>> values) const {
    std::string kind;
    for (const auto& value : values) kind += (kind.empty() ? "" : "|") + value.first;
    return value(names, kind, help, [&target, kind, values](const std::string& text) {
      for (const auto& [word, value] : values) {
        if (text == word) {
          target = value;
          return;
        }
      }
      throw UsageError("invalid value; expected " + kind + ", found '" + text + "'");
    });
  }

  /// The last word of the command: "raster".
  std::string name() const;

  /// Whether a word is a name of the command.
  bool is_called(const std::string& word) const;

  /// Whether this command is on the command line.
  bool chosen() const;

  /// The full name of every option and operand of the command, with the words given to it.
  std::vector<std::pair<std::string, std::vector<std::string>>> given() const;

  /// The command as its manual describes it.
  CommandEntry entry() const;

  /// "--radius" and so on: all long names.
  std::vector<std::string> long_names() const;

 private:
  friend class Parser;
  Options(CLI::App* app, std::string heading) : app_(app), heading_(std::move(heading)) {}
  Option listed(CLI::Option* option, const std::string& kind) const;

  CLI::App* app_;
  std::string heading_;
  bool is_required_ = false;
  std::vector<Option> needed_{}, excluded_{};
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
void add_verbosity(const Options& command, Verbosity& verbosity);

inline constexpr int k_most_threads = 1024;
/// --threads N; empty = as many as the machine has, or enough_threads() (tools/command.h).
void add_threads(const Options& command, std::optional<int>& threads);

/// Lets a long task fail before it starts: Error if the file is one of `inputs` by whatever name ("-" is
/// standard input; empty ones are skipped), exists and may not be replaced, is no regular file, or if its
/// folder cannot be written to.
void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs = {});

/// check_writable() for all files that a command writes; empty names are left out. Errors: two are one file.
void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs = {});

/// Whether two names are those of one file, which need not exist.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// The help text of a cloud's files, for commands that have nothing to add.
inline constexpr const char* k_cloud_help =
    "cloud files, folders or patterns such as 'tiles/*.las', joined into one cloud, a catalog of files "
    "(.catalog.json), an index file (.alidade), or a table of a database: site.db?table=NAME or "
    "postgresql://HOST/DATABASE?table=NAME";

/// Beginning and end of other help texts of a cloud's files.
inline const std::string k_files_help =
    "cloud files, folders or patterns such as 'tiles/*.las', joined into one cloud";
inline const std::string k_database_help =
    "; or a table of a database: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// Declares the option, or the operand, that takes the files of a cloud; folders and patterns are expanded
/// (resolve_clouds()) while the command line is read. `view`: which of their points are selected
/// (tools/view_options.h). Errors then: those of resolve_clouds().
Option add_cloud_files(const Options& command, const std::string& name, const std::string& kind,
                       const std::string& help, CloudInputs& clouds,
                       const std::shared_ptr<ViewRequest>& view);

/// Declares --partial.
Option add_partial(const Options& command, bool& partial);

/// The words the program was started with, as they go into the metadata of what it writes.
using CommandLine = std::vector<std::string>;

/// How a command is to be run, whatever it does.
struct RunRequest {
  bool partial = false;        ///< ReadOptions::partial
  std::optional<int> threads;  ///< empty: all of the machine
  Verbosity verbosity = Verbosity::normal;
  CommandLine words;  ///< of the program, filled by command_of() when it runs
};

/// Declares --partial, --threads, -q and -v.
void add_run_options(const Options& command, RunRequest& request);

/// Options of all commands on one cloud.
struct CloudRequest : RunRequest {
  CloudInputs files;

  /// The files of the cloud, and other files that are read.
  std::vector<std::filesystem::path> inputs(std::initializer_list<std::filesystem::path> more = {}) const;
};

/// Declares the operand that names the cloud, which is required, and add_view_options() without those that
/// the command has itself.
void add_cloud(const Options& command, CloudRequest& request,
               std::initializer_list<std::string_view> own_options = {});

/// Whether and where to save finished work of a long run.
struct CheckpointRequest {
  std::optional<Options> command{};  ///< whose options were declared
  std::filesystem::path file;        ///< --checkpoint; empty: nothing is kept
  double interval = 60.0;            ///< --checkpoint-interval, seconds
  bool resume = false;               ///< --resume
};

/// Declares --checkpoint, --checkpoint-interval and --resume. For the manual: `when` a checkpoint is written,
/// what the command writes, and whether a checkpoint is a FILE or a FOLDER.
void add_checkpoint_options(const Options& command, CheckpointRequest& request,
                            const std::string& when = "every --checkpoint-interval seconds",
                            const std::string& output = "output", const std::string& kind = "FILE");

/// Warns of the first checkpoint that cannot be written: the next ones will probably fail like it.
std::function<void(const Error&)> checkpoint_warning();

/// Prints how to resume after an interruption.
void say_how_to_resume(Verbosity verbosity, const std::string& checkpoint);

/// A date and time, separated by the T of scene files or by a blank.
Moment parse_moment(std::string text);

/// The parts of a text between its commas, one at least.
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

/// split_list() of a text with so many parts. Errors: another number; `expected` in words, such as "X,Y,Z".
std::vector<std::string> split_list(const std::string& text, std::size_t count, const std::string& expected);

/// "2,6": classes of points.
std::bitset<256> parse_classes(const std::string& text);

/// "800000000", "512M", "2G": bytes. Errors: UsageError.
std::size_t parse_size(const std::string& text);
/// parse_size() for memory to sort points in: at least 1M.
std::size_t parse_memory(const std::string& text);

}  // namespace alidade::tools
