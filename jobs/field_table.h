// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "jobs/fields.h"

namespace alidade::jobs {

/// The fields of a request by name, for whoever fills it from anything but a command line.
///
///   const auto table = std::make_shared<FieldTable>("raster");
///   add_raster_fields(Fields(table), request);
///   table->give("observer_height", {"1.7"});
///   table->read();
class FieldTable : public FieldSink {
 public:
  /// `name` of what is requested: "visibility raster". `stops`: as of FieldSink.
  explicit FieldTable(std::string name, std::function<bool()> stops = {})
      : name_(std::move(name)), stops_(std::move(stops)) {}

  std::size_t declare(FieldEntry entry) override;
  bool is_given(std::size_t index) const override { return !texts_[index].empty(); }
  void need(std::size_t index, std::size_t other) override { entries_[index].needed.push_back(other); }
  std::string name() const override { return name_; }
  std::vector<std::pair<std::string, std::vector<std::string>>> given() const override;
  std::function<bool()> stops() const override { return stops_; }

  /// In the order of declaration.
  const std::vector<FieldEntry>& entries() const { return entries_; }

  /// What was given to the field with this index; one empty text for a flag.
  const std::vector<std::string>& texts(std::size_t index) const { return texts_[index]; }

  /// Gives a field its texts: one, but any number if it is repeated or takes words, and none for a flag.
  /// Given again, a repeated field has more of them, others have the last. `name`: any of the field's,
  /// without hyphens in front, or own_name(); '_' may stand for '-'. Errors: UsageError if there is no such
  /// field, naming the nearest, if the number of texts is wrong, or if one has a byte of value 0.
  void give(std::string_view name, std::vector<std::string> texts);

  /// The field that give() would take for this name. Errors: UsageError for an unknown name, with the nearest
  /// known one.
  const FieldEntry& entry(std::string_view name) const { return entries_[index_of(name)]; }

  /// A text in which the options of fields have their own_name(): "observer_grid" for "--observer-grid".
  /// Names of files that contain such options are left as they are.
  std::string in_own_words(std::string_view text) const;

  /// A required field of this name need not be given: the caller has another way for it.
  void waive(std::string_view name);

  /// Reads all that was given, in the order of declaration. Errors: UsageError, which names the field in own
  /// words: a value is wrong, a field is missing, or given without one that it needs or beside one that it
  /// excludes.
  void read() const;

 private:
  std::size_t index_of(std::string_view name) const;

  std::string name_;
  std::function<bool()> stops_;
  std::vector<FieldEntry> entries_{};
  /// Empty for fields that were not given; a flag that was given has one empty text.
  std::vector<std::vector<std::string>> texts_{};
};

/// The command line that means the same, for the metadata of outputs: "alidade visibility raster site.las
/// --observer 1,2,3", with names of files as kept_name(), without fields that cannot change answers and those
/// in `silent`.
std::string command_text(const FieldTable& table, std::span<const std::string_view> silent = {});

/// Whether a command line names the value by its position alone.
bool is_operand(const FieldEntry& field);

/// The names of a field without hyphens in front: "o", "output".
std::vector<std::string> plain_names(const FieldEntry& field);
/// The first of them that is not an option of one letter: the name in messages. Others are those of other
/// programs.
std::string long_name(const FieldEntry& field);
/// long_name() with '_' for '-'; `files` for an operand with any number of words.
std::string own_name(const FieldEntry& field);

}  // namespace alidade::jobs
