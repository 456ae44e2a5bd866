// SPDX-License-Identifier: MIT
#include "jobs/field_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/shown_text.h"
#include "base/words.h"
#include "jobs/long_run.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

bool takes_many(const FieldEntry& field) {
  return field.form == FieldForm::repeated || field.form == FieldForm::words;
}

std::string with_underscores(std::string name) {
  std::ranges::replace(name, '-', '_');
  return name;
}

/// Whether the part of a text from `begin` to `end` is a word of a sentence, not a part of a file's name.
bool is_word(std::string_view text, std::size_t begin, std::size_t end) {
  if (begin > 0 && std::string_view(" '\"(").find(text[begin - 1]) == text.npos) return false;
  const std::string_view rest = text.substr(end, 2);
  return !rest.starts_with('/') && (rest.size() < 2 || rest[0] != '.' || rest[1] == ' ');
}

}  // namespace

std::vector<std::string> plain_names(const FieldEntry& field) {
  std::vector<std::string> names = split_list(field.names);
  for (std::string& name : names) name.erase(0, std::min(name.find_first_not_of('-'), name.size()));
  return names;
}

std::string long_name(const FieldEntry& field) {
  const auto is_letter = [](const std::string& name) { return name.size() == 2 && name.starts_with('-'); };
  const std::vector<std::string> names = split_list(field.names);
  const auto first = std::ranges::find_if_not(names, is_letter);
  return plain_names(field)[static_cast<std::size_t>(first == names.end() ? 0 : first - names.begin())];
}

std::string own_name(const FieldEntry& field) {
  const bool are_files = is_operand(field) && field.form == FieldForm::words;
  return are_files ? "files" : with_underscores(long_name(field));
}

std::size_t FieldTable::declare(FieldEntry entry) {
  entries_.push_back(std::move(entry));
  texts_.emplace_back();
  return entries_.size() - 1;
}

std::vector<std::pair<std::string, std::vector<std::string>>> FieldTable::given() const {
  std::vector<std::pair<std::string, std::vector<std::string>>> all;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const bool is_flag = entries_[i].form == FieldForm::flag;
    all.emplace_back(long_name(entries_[i]),
                     is_flag && is_given(i) ? std::vector<std::string>{"true"} : texts_[i]);
  }
  return all;
}

void FieldTable::give(std::string_view name, std::vector<std::string> texts) {
  const std::size_t i = index_of(name);
  const FieldEntry& field = entries_[i];
  const bool is_flag = field.form == FieldForm::flag;
  if (is_flag ? !texts.empty() : takes_many(field) ? texts.size() < field.least : texts.size() != 1)
    throw UsageError(fmt::format("{}: expected {}, found {}", name,
                                 is_flag ? "no value"
                                 : takes_many(field)
                                     ? fmt::format("at least {}", quantity(field.least, "values"))
                                     : "one value",
                                 texts.size()));
  // Names of files and conditions would end there.
  for (const std::string& text : texts)
    if (text.find('\0') != text.npos)
      throw UsageError(fmt::format("{}: invalid value; expected a text without bytes of value 0, found '{}'",
                                   name, line_text(text)));
  if (is_flag) texts = {""};
  if (field.form != FieldForm::repeated) texts_[i].clear();
  std::ranges::move(texts, std::back_inserter(texts_[i]));
}

std::size_t FieldTable::index_of(std::string_view name) const {
  const std::string wanted = with_underscores(std::string(name));
  std::vector<std::string> known;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    std::vector<std::string> names = plain_names(entries_[i]);
    names.push_back(own_name(entries_[i]));
    for (std::string& one : names) {
      one = with_underscores(std::move(one));
      if (one == wanted) return i;
      known.push_back(std::move(one));
    }
  }
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string_view nearest = nearest_word(wanted, views);
  throw UsageError(fmt::format("unknown field '{}' of {}{}", name, name_,
                               nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest)));
}

std::string FieldTable::in_own_words(std::string_view text) const {
  std::string words;
  for (std::size_t end = 0; end < text.size();) {
    const std::size_t begin = std::min(text.find("--", end), text.size());
    words += text.substr(end, begin - end);
    end = std::min(text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_", begin), text.size());
    const std::string_view option = text.substr(begin, end - begin);
    const auto field = std::ranges::find_if(entries_, [option](const FieldEntry& entry) {
      return option.size() > 2 && std::ranges::count(plain_names(entry), option.substr(2)) > 0;
    });
    words += field != entries_.end() && is_word(text, begin, end) ? own_name(*field) : std::string(option);
  }
  return words;
}

void FieldTable::waive(std::string_view name) {
  for (FieldEntry& field : entries_)
    if (std::ranges::count(plain_names(field), name) > 0) field.is_required = false;
}

void FieldTable::read() const {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const FieldEntry& field = entries_[i];
    const std::string name = own_name(field);
    if (!is_given(i)) {
      if (field.is_required) throw UsageError(fmt::format("missing {}; expected {}", name, field.kind));
      continue;
    }
    for (const std::size_t other : field.needed)
      if (!is_given(other)) throw UsageError(fmt::format("{} requires {}", name, own_name(entries_[other])));
    for (const std::size_t other : field.excluded)
      if (is_given(other)) throw UsageError(fmt::format("{} excludes {}", name, own_name(entries_[other])));
    try {
      field.read(field.form == FieldForm::flag ? std::vector<std::string>{} : texts_[i]);
    } catch (const UsageError& error) {
      throw UsageError(name + ": " + error.what());
    }
  }
}

std::string command_text(const FieldTable& table, std::span<const std::string_view> silent) {
  const auto quoted = [](const std::string& word) {
    const bool is_plain = !word.empty() && word.find_first_of(" \t'\"") == std::string::npos;
    return is_plain ? word : fmt::format("\"{}\"", word);
  };
  std::string operands, options;
  for (std::size_t i = 0; i < table.entries().size(); ++i) {
    const FieldEntry& field = table.entries()[i];
    const std::string name = long_name(field);
    if (!table.is_given(i) || is_silent(name, silent)) continue;
    const std::string option = " --" + name;
    if (field.form == FieldForm::flag) {
      options += option;
      continue;
    }
    for (const std::string& one : table.texts(i)) {
      if (!is_operand(field)) options += option;
      (is_operand(field) ? operands : options) += " " + quoted(kept_name(one));
    }
  }
  return "alidade " + table.name() + operands + options;
}

bool is_operand(const FieldEntry& field) {
  return !field.names.starts_with("-");
}

}  // namespace alidade::jobs
