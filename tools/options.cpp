// SPDX-License-Identifier: MIT
#include "tools/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/output_file.h"
#include "base/words.h"
#include "camera/camera.h"
#include "tools/cloud/load_cloud.h"
#include "tools/view_options.h"

namespace alidade::tools {
namespace {

constexpr std::uint64_t k_largest_side = 65536;

/// Any double; NaN for text that is not a number.
double parse_double(const std::string& text) {
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? number : std::numeric_limits<double>::quiet_NaN();
}

/// CLI11's heading of options without one.
constexpr std::string_view k_first_heading = "Options";

/// A function that reads a value as `take` does, and names the option in its errors.
Options::Take naming(const std::string& names, Options::Take take) {
  return [names, take = std::move(take)](const std::string& text) {
    try {
      take(text);
    } catch (const UsageError& error) {
      throw CLI::ValidationError(names, error.what());
    }
  };
}

OptionEntry entry_of(const CLI::Option& option) {
  OptionEntry entry{.kind = std::string(trim(option.get_option_text())),
                    .help = option.get_description(),
                    .is_operand = option.get_positional()};
  if (entry.is_operand) {
    entry.names.push_back(entry.kind.empty() ? option.get_single_name() : std::exchange(entry.kind, {}));
    return entry;
  }
  entry.heading = option.get_group() == k_first_heading ? "" : option.get_group();
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  return entry;
}

CommandEntry entry_of(const CLI::App& app) {
  CommandEntry entry{
      .words = {app.get_name()}, .description = app.get_description(), .text = app.get_footer()};
  std::ranges::copy(app.get_aliases(), std::back_inserter(entry.words));
  for (const CLI::App* command = &app; command != nullptr; command = command->get_parent())
    entry.name = command->get_name() + (entry.name.empty() ? "" : " " + entry.name);
  entry.usage = entry.name + " [OPTIONS]";
  for (const CLI::Option* option : app.get_options()) {
    entry.options.push_back(entry_of(*option));
    if (entry.options.back().is_operand) entry.usage += " " + entry.options.back().names.front();
  }
  for (const CLI::App* part : app.get_subcommands({})) entry.parts.push_back(entry_of(*part));
  if (!entry.parts.empty()) entry.usage += app.get_require_subcommand_min() > 0 ? " COMMAND" : " [COMMAND]";
  return entry;
}

/// The command that was chosen: of a group, the one in it.
const CLI::App* deepest(const CLI::App& app) {
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  return chosen;
}

/// The parser's error about missing words, in the words of the manual.
std::string explain(const CLI::ParseError& error, const CLI::App& command) {
  const std::string text = error.what();
  const CommandEntry entry = entry_of(command);
  if (text.starts_with("A subcommand is required")) {
    std::vector<std::string> words;
    for (const CommandEntry& part : entry.parts) words.push_back(part.words.front());
    return fmt::format("missing command; expected one of {}", fmt::join(words, ", "));
  }
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    const OptionEntry what = entry_of(*option);
    const std::string form = what.is_operand ? what.names.front() : what.names.back() + " " + what.kind;
    if (text == name + " is required") return fmt::format("missing {}; expected {}", form, entry.usage);
    if (!text.starts_with(name + ": ")) continue;
    if (text.find("required TEXT missing") != text.npos)
      return fmt::format("{}: missing value; expected {}", name, form);
    if (text.find("At least ") != text.npos) return fmt::format("too few operands; expected {}", form);
  }
  return text;
}

}  // namespace

double parse_number(const std::string& text, double least, double most) {
  const double number = parse_double(text);
  if (!std::isfinite(number)) throw UsageError("invalid value; expected a number, found '" + text + "'");
  if (number < least || number > most)
    throw UsageError(
        fmt::format("invalid value; expected a number from {} to {}, found '{}'", least, most, text));
  return number;
}

double parse_limit(const std::string& text) {
  const double limit = parse_double(text);
  if (std::isnan(limit))
    throw UsageError("invalid value; expected a number, inf or -inf, found '" + text + "'");
  return limit;
}

std::optional<double> parse_length_limit(const std::string& text) {
  const double length = parse_double(text);
  if (!(length >= 0.0))
    throw UsageError("invalid value; expected a number, at least 0, or inf, found '" + text + "'");
  return std::isinf(length) ? std::nullopt : std::optional(length);
}

double parse_distance_limit(const std::string& text) {
  return parse_length_limit(text).value_or(std::numeric_limits<double>::infinity());
}

std::uint64_t parse_count(const std::string& text, std::uint64_t least, std::uint64_t most) {
  const auto reject = [&]() -> UsageError {
    return UsageError(
        fmt::format("invalid value; expected an integer from {} to {}, found '{}'", least, most, text));
  };
  std::uint64_t count = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, count);
  if (error != std::errc() || stop != end) {
    // Written with an exponent: exact as long as it is below 2^53.
    const double number = parse_number(text);
    if (!(number >= 0.0 && number <= 9007199254740992.0) || number != std::floor(number)) throw reject();
    count = static_cast<std::uint64_t>(number);
  }
  if (count < least || count > most) throw reject();
  return count;
}

ImageSize parse_image_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos)
    throw UsageError("invalid value; expected WIDTHxHEIGHT in pixels, such as 600x400, found '" + text + "'");
  const std::uint64_t width = parse_count(text.substr(0, cross), 1, k_largest_side);
  const std::uint64_t height = parse_count(text.substr(cross + 1), 1, k_largest_side);
  if (width * height > camera::k_max_pixels) {
    throw UsageError(fmt::format("invalid value; expected at most {} pixels in total, found {}",
                                 camera::k_max_pixels, width * height));
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

std::vector<std::string> split_list(const std::string& text, std::size_t count, const std::string& expected) {
  std::vector<std::string> words = split_list(text);
  if (words.size() != count)
    throw UsageError(fmt::format("invalid value; expected {}, found '{}'", expected, text));
  return words;
}

std::bitset<256> parse_classes(const std::string& text) {
  std::bitset<256> classes;
  for (const std::string& word : split_list(text))
    classes.set(static_cast<std::size_t>(parse_count(word, 0, 255)));
  return classes;
}

std::size_t parse_size(const std::string& text) {
  constexpr std::uint64_t k_most = std::uint64_t{1} << 50;
  const std::string_view units = "kMGT";
  const std::size_t unit = text.empty() ? units.npos : units.find(text.back());
  if (unit == units.npos) return static_cast<std::size_t>(parse_count(text, 1, k_most));
  const double factor = std::pow(1024.0, static_cast<double>(unit + 1));
  const double number =
      parse_number(text.substr(0, text.size() - 1), 0, static_cast<double>(k_most) / factor);
  return static_cast<std::size_t>(std::max(number * factor, 1.0));
}

std::size_t parse_memory(const std::string& text) {
  constexpr std::size_t k_least = std::size_t{1} << 20;
  const std::size_t memory = parse_size(text);
  if (memory < k_least) throw UsageError("invalid value; expected at least 1M, found '" + text + "'");
  return memory;
}

Moment parse_moment(std::string text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() > k_date_length && text[k_date_length] == ' ') text[k_date_length] = 'T';
  try {
    return parse_date_time(text);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

void Option::needs(const Option& other) const {
  option_->needs(other.option_);
}

bool Option::given() const {
  return option_->count() > 0;
}

Options Options::group(const std::string& heading) const {
  Options options = *this;
  options.heading_ = heading;
  return options;
}

Options Options::required() const {
  Options options = *this;
  options.is_required_ = true;
  return options;
}

Options Options::needs(const Option& other) const {
  Options options = *this;
  options.needed_.push_back(other);
  return options;
}

Options Options::excludes(const Option& other) const {
  Options options = *this;
  options.excluded_.push_back(other);
  return options;
}

Options Options::command(const std::string& name, const std::string& description) const {
  CLI::App* const command = app_->add_subcommand(name, description);
  command->footer(std::string(tools::manual(app_->get_parent() ? app_->get_name() + "_" + name : name)));
  return {command, {}};
}

Options Options::also_called(const std::string& name) const {
  app_->alias(name);
  return *this;
}

Options Options::require_command() const {
  app_->require_subcommand(1);
  return *this;
}

void Options::manual(const std::string& text) const {
  app_->footer(text);
}

Option Options::listed(CLI::Option* option, const std::string& kind) const {
  option->option_text(kind);
  if (!heading_.empty()) option->group(heading_);
  option->required(is_required_);
  for (const Option& other : needed_) option->needs(other.option_);
  for (const Option& other : excluded_) option->excludes(other.option_);
  return Option(option);
}

Option Options::value(const std::string& names, const std::string& kind, const std::string& help,
                      Take take) const {
  return listed(
      app_->add_option_function<std::string>(names, naming(names, std::move(take)), help)->take_last(), kind);
}

Option Options::values(const std::string& names, const std::string& kind, const std::string& help,
                       Take take) const {
  const auto take_all = [take = naming(names, std::move(take))](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) take(text);
  };
  return listed(
      app_->add_option_function<std::vector<std::string>>(names, take_all, help)->allow_extra_args(false),
      kind);
}

Option Options::words(const std::string& names, const std::string& kind, const std::string& help,
                      std::function<void(const std::vector<std::string>&)> take, int least) const {
  CLI::Option* const option =
      app_->add_option_function<std::vector<std::string>>(names, std::move(take), help);
  if (least > 1) option->expected(least, -1);
  return listed(option, kind);
}

Option Options::text(const std::string& names, const std::string& kind, const std::string& help,
                     std::string& target) const {
  return listed(app_->add_option(names, target, help), kind);
}

Option Options::text(const std::string& names, const std::string& kind, const std::string& help,
                     std::vector<std::string>& target) const {
  return listed(app_->add_option(names, target, help)->allow_extra_args(false), kind);
}

Option Options::file(const std::string& names, const std::string& kind, const std::string& help,
                     std::filesystem::path& target) const {
  return listed(app_->add_option(names, target, help), kind);
}

Option Options::flag(const std::string& names, const std::string& help, bool& target) const {
  return listed(app_->add_flag(names, target, help), " ");
}

Option Options::flag(const std::string& names, const std::string& help, std::function<void()> take) const {
  return listed(app_->add_flag_callback(names, std::move(take), help), " ");
}

std::string Options::name() const {
  return app_->get_name();
}

bool Options::is_called(const std::string& word) const {
  return app_->check_name(word);
}

bool Options::chosen() const {
  return app_->parsed();
}

std::vector<std::pair<std::string, std::vector<std::string>>> Options::given() const {
  std::vector<std::pair<std::string, std::vector<std::string>>> all;
  for (const CLI::Option* option : app_->get_options())
    all.emplace_back(option->get_single_name(), option->results());
  return all;
}

CommandEntry Options::entry() const {
  return entry_of(*app_);
}

std::vector<std::string> Options::long_names() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : app_->get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

Parser::Parser()
    : app_(std::make_unique<CLI::App>(
          "Alidade: ray queries on raw point clouds, and path-traced images of them.", "alidade")) {
  app_->require_subcommand(1);
  app_->set_version_flag("--version", ALIDADE_VERSION);
  app_->footer(std::string(manual("alidade")));
}

Parser::~Parser() = default;

Options Parser::program() const {
  return {app_.get(), {}};
}

Parser::Action Parser::parse(std::span<const std::string> words) {
  try {
    // The parser takes the words last one first.
    app_->parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    return Action::help;
  } catch (const CLI::CallForVersion&) {
    return Action::version;
  } catch (const CLI::ParseError& error) {
    throw UsageError(explain(error, *deepest(*app_)));
  }
  return Action::work;
}

std::string Parser::help() const {
  return help_text(entry_of(*deepest(*app_)));
}

void add_verbosity(const Options& command, Verbosity& verbosity) {
  const Option quiet =
      command.flag("-q,--quiet", "print errors only", [&verbosity] { verbosity = Verbosity::quiet; });
  command.excludes(quiet).flag("-v,--verbose", "print details",
                               [&verbosity] { verbosity = Verbosity::verbose; });
}

void add_threads(const Options& command, std::optional<int>& threads) {
  command.count("--threads", "N",
                "number of threads (default: all; 8 times as many for rays through an index file larger than "
                "memory); results do not depend on it",
                threads, 1, k_most_threads);
}

void check_writable(const std::filesystem::path& output, bool overwrite,
                    std::span<const std::filesystem::path> inputs) {
  std::error_code error;
  for (const std::filesystem::path& input : inputs) {
    // A missing file equals none; reading it reports that it is missing.
    if (std::filesystem::equivalent(output, input == "-" ? "/dev/stdin" : input, error))
      throw file_error(output, "the output is also an input", "another output name");
  }
  if (has_extension(output.stem(), {".copc"}) && has_extension(output, {".las"}))
    throw file_error(output, "COPC is compressed", "the extension .copc.laz");
  if (!overwrite && std::filesystem::is_regular_file(output, error))
    throw file_error(output, "the file exists", "another name, or --overwrite");
  // Opened and given up at once: this finds a missing or read-only folder as the later writing would.
  const OutputFile attempt(output, overwrite);
}

void check_outputs(std::span<const std::filesystem::path> outputs, bool overwrite,
                   std::span<const std::filesystem::path> inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    check_writable(outputs[i], overwrite, inputs);
    for (const std::filesystem::path& earlier : outputs.first(i)) {
      if (earlier.empty() || !same_file(earlier, outputs[i])) continue;
      throw file_error(outputs[i], "two outputs have this name", "different names");
    }
  }
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto canonical = [](const std::filesystem::path& path) {
    std::error_code error;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  };
  return canonical(a) == canonical(b);
}

Option add_cloud_files(const Options& command, const std::string& name, const std::string& kind,
                       const std::string& help, CloudInputs& clouds,
                       const std::shared_ptr<ViewRequest>& view) {
  return command.words(name, kind, help, [&clouds, view](const std::vector<std::string>& words) {
    clouds = view->apply(
        resolve_clouds(std::vector<std::filesystem::path>(words.begin(), words.end()), cloud_formats()));
  });
}

Option add_partial(const Options& command, bool& partial) {
  return command.flag(
      "--partial", "read the intact part of damaged files and report what is lost; otherwise they are errors",
      partial);
}

void add_cloud(const Options& command, CloudRequest& request,
               std::initializer_list<std::string_view> own_options) {
  add_cloud_files(command.required(), "cloud", "CLOUD...", k_cloud_help, request.files,
                  add_view_options(command, own_options));
}

std::vector<std::filesystem::path> CloudRequest::inputs(
    std::initializer_list<std::filesystem::path> more) const {
  std::vector<std::filesystem::path> all = files.names();
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

void add_run_options(const Options& command, RunRequest& request) {
  add_partial(command, request.partial);
  add_threads(command, request.threads);
  add_verbosity(command, request.verbosity);
}

void add_checkpoint_options(const Options& command, CheckpointRequest& request, const std::string& when,
                            const std::string& output, const std::string& kind) {
  constexpr double k_most_seconds = 1e9;
  request.command = command;
  const Option checkpoint =
      command.value("--checkpoint", kind,
                    fmt::format("save finished work to {}, {} and on Ctrl-C; deleted once the {} is written",
                                kind, when, output),
                    request.file, std::identity());
  command.needs(checkpoint)
      .number("--checkpoint-interval", "S", "seconds between checkpoints, above 0 (default 60)",
              request.interval, 1e-3, k_most_seconds);
  command.needs(checkpoint)
      .flag("--resume",
            fmt::format(
                "continue from the checkpoint if it exists; the {} has the bytes of an uninterrupted run",
                output),
            request.resume);
}

std::function<void(const Error&)> checkpoint_warning() {
  return [said = false](const Error& error) mutable {
    if (!said) say_warning(std::string("no checkpoint: ") + error.what());
    said = true;
  };
}

void say_how_to_resume(Verbosity verbosity, const std::string& checkpoint) {
  say_note(verbosity, "saved to " + checkpoint + "; the same command with --resume continues");
}

}  // namespace alidade::tools
