// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/date_time.h"

// The fields of requests. A request is a plain struct; a function declares its fields once, with their names,
// limits, units and help. Whoever fills requests, such as a command line, is a FieldSink. Values are texts
// until a field reads them, strictly: a value with anything behind the number is an error, as is one outside
// its limits.

namespace alidade::jobs {

/// A wrong value or use of a field; the message does not name the field.
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

/// A date and time, separated by the T of scene files or by a blank.
Moment parse_moment(std::string text);

/// The parts of a text between its commas, one at least.
std::vector<std::string> split_list(const std::string& text);

/// split_list() of a text with so many parts. Errors: another number; `expected` in words, such as "X,Y,Z".
std::vector<std::string> split_list(const std::string& text, std::size_t count, const std::string& expected);

/// "2,6": classes of points.
std::bitset<256> parse_classes(const std::string& text);

/// "800000000", "512M", "2G": bytes.
std::size_t parse_size(const std::string& text);
/// parse_size() for memory to sort points in: at least 1M.
std::size_t parse_memory(const std::string& text);

template <class Target>
struct OptionalValue {
  using type = Target;
};
template <class Value>
struct OptionalValue<std::optional<Value>> {
  using type = Value;
};

/// The type that a field stores: Value, for a target that is a Value or an optional Value.
template <class Target>
using ValueOf = typename OptionalValue<Target>::type;

/// How often a field may be given, and with how many texts.
enum class FieldForm {
  flag,      ///< without a text
  value,     ///< one text; given more than once, the last one holds
  text,      ///< one text, once
  repeated,  ///< one text each time
  words,     ///< at least FieldEntry::least texts, all at once
};

/// A field as its request declares it.
struct FieldEntry {
  std::string names{};  ///< "-o,--output", or a word without hyphens for an operand
  std::string kind{};   ///< what its text is, as "FILE"; empty for flags
  std::string help{};
  std::string heading{};  ///< of the manual; empty: the first
  FieldForm form = FieldForm::value;
  std::size_t least = 1;
  bool is_required = false;
  std::vector<std::size_t> needed{}, excluded{};  ///< indices of other fields
  /// Reads all its texts; a flag has none. Errors: UsageError.
  std::function<void(const std::vector<std::string>&)> read{};
};

/// What fields are declared to.
class FieldSink {
 public:
  virtual ~FieldSink() = default;
  /// Returns the field's index.
  virtual std::size_t declare(FieldEntry entry) = 0;
  /// Whether the field with this index was given.
  virtual bool is_given(std::size_t index) const = 0;
  /// A field with this index needs another one.
  virtual void need(std::size_t index, std::size_t other) = 0;
  /// The name of what is requested, as "raster".
  virtual std::string name() const = 0;
  /// The name without hyphens of every field, with the texts given to it, in the order of declaration.
  virtual std::vector<std::pair<std::string, std::vector<std::string>>> given() const = 0;
  /// Whether to stop: tested by values that compute, such as conditions, on many threads. May be empty.
  virtual std::function<bool()> stops() const { return {}; }
};

/// A declared field. Copies refer to the same one.
class Field {
 public:
  void needs(const Field& other) const { sink_->need(index_, other.index_); }
  bool given() const { return sink_->is_given(index_); }

 private:
  friend class Fields;
  Field(std::shared_ptr<FieldSink> sink, std::size_t index) : sink_(std::move(sink)), index_(index) {}

  std::shared_ptr<FieldSink> sink_;
  std::size_t index_;
};

/// The fields of a request, or those under one heading of its manual. Copies refer to the same request.
/// Values are stored in `target`, which must live as long as fields are read; a function that reads a value
/// throws UsageError.
class Fields {
 public:
  using Take = std::function<void(const std::string&)>;

  explicit Fields(std::shared_ptr<FieldSink> sink) : sink_(std::move(sink)) {}

  /// These fields under another heading: fields declared through the returned object are listed there.
  Fields group(const std::string& heading) const;

  /// Fields declared through the returned object are required, need `other`, or exclude `other` and are
  /// excluded by it.
  Fields required() const;
  Fields needs(const Field& other) const;
  Fields excludes(const Field& other) const;

  /// A field with a value. Given more than once, its last value holds.
  Field value(const std::string& names, const std::string& kind, const std::string& help, Take take) const;

  /// A field whose value is what `parse` makes of the text.
  template <class Target, class Parse>
  Field value(const std::string& names, const std::string& kind, const std::string& help, Target& target,
              Parse parse) const {
    return value(names, kind, help, [&target, parse](const std::string& text) { target = parse(text); });
  }

  /// A repeatable field: every value is read.
  Field values(const std::string& names, const std::string& kind, const std::string& help, Take take) const;

  /// A field, or an operand, with at least so many words behind it; all are read at once.
  Field words(const std::string& names, const std::string& kind, const std::string& help,
              std::function<void(const std::vector<std::string>&)> take, std::size_t least = 1) const;

  /// Text as it is: one of it, into a string or an optional one, or one per use.
  template <class Target>
  Field text(const std::string& names, const std::string& kind, const std::string& help,
             Target& target) const {
    return declare({.names = names,
                    .kind = kind,
                    .help = help,
                    .form = FieldForm::text,
                    .read = [&target](const auto& texts) { target = texts.back(); }});
  }
  Field text(const std::string& names, const std::string& kind, const std::string& help,
             std::vector<std::string>& target) const;

  /// The name of a file or folder, once; not an empty one if it is required.
  Field file(const std::string& names, const std::string& kind, const std::string& help,
             std::filesystem::path& target) const;

  Field flag(const std::string& names, const std::string& help, bool& target) const;
  Field flag(const std::string& names, const std::string& help, std::function<void()> take) const;

  /// A number in [least, most], as parse_number() reads it.
  template <class Target>
  Field number(const std::string& names, const std::string& kind, const std::string& help, Target& target,
               double least = std::numeric_limits<double>::lowest(),
               double most = std::numeric_limits<double>::max()) const {
    return value(names, kind, help, [&target, least, most](const std::string& text) {
      target = parse_number(text, least, most);
    });
  }

  /// A length above 0.
  template <class Target>
  Field length(const std::string& names, const std::string& kind, const std::string& help,
               Target& target) const {
    return value(names, kind, help, [&target](const std::string& text) {
      const double number = parse_number(text, 0.0);
      if (number == 0.0) throw UsageError("invalid value; expected a positive length, found '0'");
      target = number;
    });
  }

  /// A whole number in [least, most], as parse_count() reads it, into an integer or an optional one.
  template <class Target>
  Field count(const std::string& names, const std::string& kind, const std::string& help, Target& target,
              std::uint64_t least, std::uint64_t most) const {
    return value(names, kind, help, [&target, least, most](const std::string& text) {
      target = static_cast<ValueOf<Target>>(parse_count(text, least, most));
    });
  }

  /// One of the named values, which is taken, or stored.
  template <class Value>
  Field choice(const std::string& names, const std::string& help,
               std::vector<std::pair<std::string, Value>> values,
               std::function<void(const Value&)> take_value) const {
    std::string kind;
    for (const auto& value : values) kind += (kind.empty() ? "" : "|") + value.first;
    return value(names, kind, help, [take_value, kind, values](const std::string& text) {
      for (const auto& [word, value] : values)
        if (text == word) return take_value(value);
      throw UsageError("invalid value; expected " + kind + ", found '" + text + "'");
    });
  }
  template <class Target>
  Field choice(const std::string& names, const std::string& help, Target& target,
               std::vector<std::pair<std::string, ValueOf<Target>>> values) const {
    return choice<ValueOf<Target>>(names, help, std::move(values),
                                   std::function<void(const ValueOf<Target>&)>(
                                       [&target](const ValueOf<Target>& value) { target = value; }));
  }

  std::string name() const { return sink_->name(); }
  std::vector<std::pair<std::string, std::vector<std::string>>> given() const { return sink_->given(); }
  std::function<bool()> stops() const { return sink_->stops(); }

 private:
  Field declare(FieldEntry entry) const;

  std::shared_ptr<FieldSink> sink_;
  std::string heading_{};
  bool is_required_ = false;
  std::vector<std::size_t> needed_{}, excluded_{};
};

}  // namespace alidade::jobs
