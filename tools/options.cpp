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

namespace alidade::tools {
namespace {

/// CLI11's heading of options without one.
constexpr std::string_view k_first_heading = "Options";

/// Fields as options of a command.
class OptionSink : public jobs::FieldSink {
 public:
  explicit OptionSink(CLI::App* app) : app_(app) {}

  std::size_t declare(jobs::FieldEntry field) override {
    CLI::Option* const option = add(field);
    option->option_text(field.form == jobs::FieldForm::flag ? " " : field.kind);
    if (!field.heading.empty()) option->group(field.heading);
    option->required(field.is_required);
    for (const std::size_t other : field.needed) option->needs(options_[other]);
    for (const std::size_t other : field.excluded) option->excludes(options_[other]);
    options_.push_back(option);
    return options_.size() - 1;
  }

  bool is_given(std::size_t index) const override { return options_[index]->count() > 0; }
  void need(std::size_t index, std::size_t other) override { options_[index]->needs(options_[other]); }
  std::string name() const override { return app_->get_name(); }
  std::function<bool()> stops() const override { return &interrupted; }

  std::vector<std::pair<std::string, std::vector<std::string>>> given() const override {
    std::vector<std::pair<std::string, std::vector<std::string>>> all;
    for (const CLI::Option* option : app_->get_options())
      all.emplace_back(option->get_single_name(), option->results());
    return all;
  }

 private:
  CLI::Option* add(const jobs::FieldEntry& field) {
    const std::string& names = field.names;
    // Errors name the option, but for those of words, which are not of one value.
    const auto read_all = [names, read = field.read](const std::vector<std::string>& texts) {
      try {
        read(texts);
      } catch (const UsageError& error) {
        throw CLI::ValidationError(names, error.what());
      }
    };
    const auto read_one = [read_all](const std::string& text) { read_all({text}); };
    switch (field.form) {
      case jobs::FieldForm::flag:
        return app_->add_flag_callback(
            names, [read_all] { read_all({}); }, field.help);
      case jobs::FieldForm::value:
        return app_->add_option_function<std::string>(names, read_one, field.help)->take_last();
      case jobs::FieldForm::text:
        return app_->add_option_function<std::string>(names, read_one, field.help);
      case jobs::FieldForm::repeated:
        return app_->add_option_function<std::vector<std::string>>(names, read_all, field.help)
            ->allow_extra_args(false);
      case jobs::FieldForm::words:
        break;
    }
    CLI::Option* const option =
        app_->add_option_function<std::vector<std::string>>(names, field.read, field.help);
    if (field.least > 1) option->expected(static_cast<int>(field.least), -1);
    return option;
  }

  CLI::App* app_;
  std::vector<CLI::Option*> options_;
};

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

Options::Options(CLI::App* app) : Fields(std::make_shared<OptionSink>(app)), app_(app) {}

Options Options::command(const std::string& name, const std::string& description) const {
  CLI::App* const command = app_->add_subcommand(name, description);
  command->footer(std::string(tools::manual(app_->get_parent() ? app_->get_name() + "_" + name : name)));
  return Options(command);
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

bool Options::is_called(const std::string& word) const {
  return app_->check_name(word);
}

bool Options::chosen() const {
  return app_->parsed();
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
  return Options(app_.get());
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

void add_verbosity(const Fields& command, Verbosity& verbosity) {
  const Field quiet = command.flag("-q,--quiet", "print errors only", [&verbosity] {
    verbosity = Verbosity::quiet;
    silence_remote_notes();
  });
  command.excludes(quiet).flag("-v,--verbose", "print details",
                               [&verbosity] { verbosity = Verbosity::verbose; });
}

void add_threads(const Fields& command, std::optional<int>& threads) {
  command.count("--threads", "N",
                "number of threads (default: all; 8 times as many for rays through an index file larger than "
                "memory); results do not depend on it",
                threads, 1, k_most_threads);
}

std::function<void(const Error&)> checkpoint_warning() {
  static Console console(Verbosity::quiet);
  return jobs::checkpoint_warning(console);
}

}  // namespace alidade::tools
