// SPDX-License-Identifier: MIT
#include "jobs/field_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/words.h"
#include "jobs/long_run.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

bool takes_many(const FieldEntry& field) {
  return field.form == FieldForm::repeated || field.form == FieldForm::words;
}

std::string own_name(const FieldEntry& field) {
  std::string name = long_name(field);
  std::ranges::replace(name, '-', '_');
  return name;
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
  std::string plain(name);
  std::ranges::replace(plain, '_', '-');
  std::vector<std::string> known;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const FieldEntry& field = entries_[i];
    for (std::string own : plain_names(field)) {
      std::ranges::replace(own, '_', '-');
      known.push_back(own);
      if (own != plain) continue;
      const bool is_flag = field.form == FieldForm::flag;
      if (is_flag ? !texts.empty() : takes_many(field) ? texts.size() < field.least : texts.size() != 1)
        throw UsageError(fmt::format("{}: expected {}, found {} values", name,
                                     is_flag             ? "no value"
                                     : takes_many(field) ? fmt::format("at least {}", field.least)
                                                         : "one value",
                                     texts.size()));
      if (is_flag) texts = {""};
      if (field.form != FieldForm::repeated) texts_[i].clear();
      std::ranges::move(texts, std::back_inserter(texts_[i]));
      return;
    }
  }
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string_view nearest = nearest_word(plain, views);
  throw UsageError(fmt::format("unknown field '{}' of {}{}", name, name_,
                               nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest)));
}

std::string FieldTable::in_own_words(std::string_view text) const {
  std::string words;
  while (true) {
    const std::size_t begin = text.find("--");
    words += text.substr(0, begin);
    if (begin == text.npos) return words;
    text.remove_prefix(begin + 2);
    const std::size_t length =
        std::min(text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_"), text.size());
    const std::string_view option = text.substr(0, length);
    const auto field = std::ranges::find_if(entries_, [option](const FieldEntry& entry) {
      return std::ranges::count(plain_names(entry), option) > 0;
    });
    words += field == entries_.end() ? "--" + std::string(option) : own_name(*field);
    text.remove_prefix(length);
  }
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
