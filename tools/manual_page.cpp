// SPDX-License-Identifier: MIT
#include "tools/manual_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <string_view>

#include "base/words.h"

namespace alidade::tools {
namespace {

constexpr std::size_t k_width = 100, k_column = 30;

/// Appends words to lines that begin at a column, from the second line on after blanks. `at`: length of the
/// current line so far.
void wrap(std::string& text, std::size_t at, std::size_t column, std::string_view words) {
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find(' ', begin), words.size());
    std::string_view word = words.substr(begin, end - begin);
    begin = end + 1;
    const auto end_line = [&] {
      text += "\n" + std::string(column, ' ');
      at = column;
    };
    if (word.empty()) continue;
    if (at > column && at + 1 + word.size() > k_width) end_line();
    if (at > column) text += ' ', ++at;
    // Lists of names are wider than the column.
    for (std::size_t comma = 0; at + word.size() > k_width; end_line()) {
      comma = word.rfind(',', k_width - at - 1);
      if (comma == word.npos) break;
      text += word.substr(0, comma + 1);
      word.remove_prefix(comma + 1);
    }
    text += word;
    at += word.size();
  }
  text += "\n";
}

/// The headings of some options in the order of their first use.
std::vector<std::string> headings_of(const CommandEntry& command) {
  std::vector<std::string> headings;
  for (const OptionEntry& option : command.options) {
    if (!option.is_operand && std::ranges::find(headings, option.heading) == headings.end())
      headings.push_back(option.heading);
  }
  return headings;
}

std::string called(const OptionEntry& option) {
  return fmt::format("{}{}{}", fmt::join(option.names, ","), option.kind.empty() ? "" : " ", option.kind);
}

/// Whether a table lists an option: that of the operands, or that of the heading.
bool is_listed(const OptionEntry& option, bool operands, const std::string& heading) {
  return option.is_operand == operands && (operands || option.heading == heading);
}

/// Visits each table of a manual: its heading, and whether it has operands.
template <class Visit>
void for_each_table(const CommandEntry& command, const Visit& visit) {
  if (std::ranges::any_of(command.options, &OptionEntry::is_operand)) visit("Operands", true, std::string());
  for (const std::string& heading : headings_of(command))
    visit(heading.empty() ? std::string("Options") : heading, false, heading);
}

/// Text that troff shows as it is.
std::string roff(std::string_view text) {
  std::string escaped;
  for (const char character : text) {
    const bool begins_line = escaped.empty() || escaped.back() == '\n';
    if (character == '\\')
      escaped += "\\e";
    else if (character == '-')
      escaped += "\\-";
    else if (begins_line && (character == '.' || character == '\''))
      escaped += std::string("\\&") + character;
    else
      escaped += character;
  }
  return escaped;
}

std::string page_name(const CommandEntry& command) {
  std::string name = command.name;
  std::ranges::replace(name, ' ', '-');
  return name;
}

/// The words of "8|16"; none of a kind such as FILE, or that also takes others.
std::vector<std::string> choices_of(const OptionEntry& option) {
  if (option.kind.find('|') == std::string::npos) return {};
  std::vector<std::string> words;
  std::string_view rest = option.kind;
  while (true) {
    const std::size_t end = std::min(rest.find('|'), rest.size());
    const std::string_view word = rest.substr(0, end);
    const auto is_plain = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    };
    if (word.empty() || !std::ranges::all_of(word, is_plain)) return {};
    words.emplace_back(word);
    if (end == rest.size()) return words;
    rest.remove_prefix(end + 1);
  }
}

std::vector<std::string> words_of_parts(const CommandEntry& command) {
  std::vector<std::string> words;
  for (const CommandEntry& part : command.parts) std::ranges::copy(part.words, std::back_inserter(words));
  return words;
}

/// Visits the program, its commands and those of its groups.
template <class Visit>
void for_each_command(const CommandEntry& command, const Visit& visit) {
  visit(command);
  for (const CommandEntry& part : command.parts) for_each_command(part, visit);
}

/// The first clause of a help text, for lists of completions.
std::string brief(const std::string& help) {
  const std::size_t end = std::min({help.find(';'), help.find(" ("), help.find(": "), help.size()});
  return help.substr(0, end);
}

}  // namespace

std::string manual_row(const std::string& first, std::string_view second, std::size_t column) {
  std::string text = first;
  std::size_t at = first.size();
  if (at >= column) {
    text += "\n";
    at = 0;
  }
  text += std::string(column - at, ' ');
  wrap(text, column, column, second);
  return text;
}

std::string help_text(const CommandEntry& command) {
  std::string text = command.description + "\n";
  const std::string usage = "Usage: ";
  text += usage;
  wrap(text, usage.size(), usage.size(), command.usage);
  for_each_table(command, [&](const std::string& title, bool operands, const std::string& heading) {
    text += "\n" + title + ":\n";
    for (const OptionEntry& option : command.options)
      if (is_listed(option, operands, heading))
        text += manual_row("  " + called(option), option.help, k_column);
  });
  if (!command.parts.empty()) text += "\nCommands:\n";
  for (const CommandEntry& part : command.parts)
    text += manual_row(fmt::format("  {}", fmt::join(part.words, ", ")), part.description, k_column);
  return text + "\n" + command.text;
}

std::string manual_page(const CommandEntry& command, const std::string& version) {
  // The date of the version, as in the changelog: builds of one source have equal bytes.
  constexpr const char* k_date = "2026-11-27";
  std::string title = page_name(command);
  std::ranges::transform(title, title.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
  std::string text = fmt::format(
      ".TH {} 1 \"{}\" \"Alidade {}\" \"Alidade\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}\n", title, k_date,
      version, roff(page_name(command)), roff(command.description), roff(command.usage));
  for_each_table(command, [&](std::string heading, bool operands, const std::string& group) {
    std::ranges::transform(heading, heading.begin(),
                           [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
    text += fmt::format(".SH \"{}\"\n", roff(heading));
    for (const OptionEntry& option : command.options) {
      if (is_listed(option, operands, group))
        text += fmt::format(".TP\n.B {}\n{}\n", roff(called(option)), roff(option.help));
    }
  });
  if (!command.parts.empty()) text += ".SH COMMANDS\n";
  for (const CommandEntry& part : command.parts)
    text += fmt::format(".TP\n.BR {} (1)\n{}\n", roff(page_name(part)), roff(part.description));
  // Forms, tables and examples keep their lines.
  text += ".SH DESCRIPTION\n.nf\n";
  std::string_view rest = trim(command.text);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    text += end == 0 ? std::string("\\&\n") : roff(rest.substr(0, end)) + "\n";
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return text + ".fi\n";
}

std::string bash_completion(const CommandEntry& program) {
  std::string text =
      "# bash completion for alidade\n"
      "_alidade() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=alidade words='' i\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    case \"$command ${COMP_WORDS[i]}\" in\n";
  std::vector<std::string> names;
  for_each_command(program, [&](const CommandEntry& command) {
    for (const CommandEntry& part : command.parts)
      for (const std::string& word : part.words)
        text += fmt::format("      '{} {}') command='{}' ;;\n", command.name, word, part.name);
  });
  text += "    esac\n  done\n  case \"$command $before\" in\n";
  for_each_command(program, [&](const CommandEntry& command) {
    for (const OptionEntry& option : command.options) {
      const std::vector<std::string> choices = choices_of(option);
      for (const std::string& name : option.names)
        if (!choices.empty() && !option.is_operand)
          text += fmt::format("    '{} {}') words='{}' ;;\n", command.name, name, fmt::join(choices, " "));
    }
  });
  text += "  esac\n  if [[ -z $words && $word == -* ]]; then\n    case $command in\n";
  for_each_command(program, [&](const CommandEntry& command) {
    std::vector<std::string> options;
    for (const OptionEntry& option : command.options)
      if (!option.is_operand) std::ranges::copy(option.names, std::back_inserter(options));
    text += fmt::format("      '{}') words='{}' ;;\n", command.name, fmt::join(options, " "));
  });
  text += "    esac\n  elif [[ -z $words ]]; then\n    case $command in\n";
  for_each_command(program, [&](const CommandEntry& command) {
    if (!command.parts.empty())
      text +=
          fmt::format("      '{}') words='{}' ;;\n", command.name, fmt::join(words_of_parts(command), " "));
  });
  return text +
         "    esac\n  fi\n  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n}\n"
         "complete -o default -F _alidade alidade\n";
}

std::string zsh_completion(const CommandEntry& program) {
  // zsh runs completions of bash, and adds its own menus.
  return "#compdef alidade\nautoload -U +X bashcompinit && bashcompinit\n" + bash_completion(program);
}

std::string fish_completion(const CommandEntry& program) {
  std::string text = "# fish completion for alidade\n";
  for_each_command(program, [&](const CommandEntry& command) {
    // "alidade visibility raster" is chosen when both words have been seen.
    std::vector<std::string> seen;
    std::string_view rest = command.name;
    while (rest.find(' ') != std::string_view::npos) {
      rest.remove_prefix(rest.find(' ') + 1);
      seen.push_back("__fish_seen_subcommand_from " + std::string(rest.substr(0, rest.find(' '))));
    }
    const std::vector<std::string> parts = words_of_parts(command);
    std::string condition = fmt::format("{}", fmt::join(seen, "; and "));
    for (const CommandEntry& part : command.parts) {
      const std::string none = fmt::format("not __fish_seen_subcommand_from {}", fmt::join(parts, " "));
      for (const std::string& word : part.words)
        text += fmt::format("complete -c alidade -n {} -a {} -d {}\n",
                            shell_word(condition.empty() ? none : condition + "; and " + none), word,
                            shell_word(part.description));
    }
    for (const OptionEntry& option : command.options) {
      if (option.is_operand) continue;
      text += "complete -c alidade";
      if (!condition.empty()) text += " -n " + shell_word(condition);
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      const std::vector<std::string> choices = choices_of(option);
      if (!choices.empty())
        text += fmt::format(" -x -a {}", shell_word(fmt::format("{}", fmt::join(choices, " "))));
      else if (!option.kind.empty())
        text += " -r";
      text += " -d " + shell_word(brief(option.help)) + "\n";
    }
  });
  return text;
}

std::vector<std::pair<std::filesystem::path, std::string>> manual_files(const CommandEntry& program,
                                                                        const std::string& version) {
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  for_each_command(program, [&](const CommandEntry& command) {
    files.emplace_back("man/man1/" + page_name(command) + ".1", manual_page(command, version));
  });
  files.emplace_back("bash-completion/completions/alidade", bash_completion(program));
  files.emplace_back("zsh/site-functions/_alidade", zsh_completion(program));
  files.emplace_back("fish/vendor_completions.d/alidade.fish", fish_completion(program));
  return files;
}

}  // namespace alidade::tools
