// SPDX-License-Identifier: MIT
#include "jobs/query/targets.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/words.h"

namespace alidade::jobs {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_not_given = std::numeric_limits<double>::quiet_NaN();

/// What rows are read from.
enum class Source {
  text,    ///< a file, a pipe, standard input
  option,  ///< values of an option
  array,   ///< of numbers
};

/// A line of a text, or a row of an array, which has no text.
struct Line {
  std::string_view source;  ///< name of the text in messages
  Source kind = Source::text;
  std::string_view text{};
  std::uint64_t number = 1;

  /// Throws an Error about the text at byte `offset`. It names source, line and column (in characters, from
  /// 1); for an option its whole value instead, if there is one, for an array the row.
  [[noreturn]] void fail(std::size_t offset, std::string problem, std::string expected = {},
                         std::string found = {}) const {
    std::string location = fmt::format("{}:{}", number, 1 + character_count(text.substr(0, offset)));
    if (kind == Source::option) location = text.empty() ? "" : " " + quote(text);
    if (kind == Source::array) location = fmt::format(" row {}", number);
    throw Error({.file = std::string(source),
                 .location = std::move(location),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  }
  std::size_t offset_of(std::string_view cell) const {
    return static_cast<std::size_t>(cell.data() - text.data());
  }
};

/// The header of a CSV: for every cell the kind's column. Errors: a name that is unknown or is repeated, a
/// required column that is missing, no names at all.
std::vector<std::size_t> read_header(const Line& line, const TargetKind& kind) {
  std::vector<std::string_view> names;
  split_cells(line.text, ',', names);
  if (alidade::parse_number(names.front()))
    line.fail(0, "missing header", "column names: " + kind.form(), quote(line.text));
  std::vector<std::size_t> columns;
  for (const std::string_view name : names) {
    const std::size_t column = kind.column(name), offset = line.offset_of(name);
    if (column == kind.columns.size()) {
      if (name.find_first_of(";\t") != name.npos)
        line.fail(offset, "columns are not separated by commas", kind.form(), quote(line.text));
      line.fail(offset, fmt::format("unknown column {}", quote(name)), "one of " + kind.names());
    }
    if (std::ranges::find(columns, column) != columns.end())
      line.fail(offset, fmt::format("duplicate column {}", name));
    columns.push_back(column);
  }
  for (std::size_t i = 0; i < kind.columns.size(); ++i) {
    if (kind.columns[i].required && std::ranges::find(columns, i) == columns.end())
      line.fail(line.text.size(), fmt::format("missing column {}", kind.columns[i].name), kind.form());
  }
  return columns;
}

/// Reads the values of one row. Errors of all that it reads: a value breaks the rule of its column, a
/// required one is missing, a direction has length zero.
class RowFiller {
 public:
  /// `row` has a value for every column of the kind: NaN, or those of an array.
  RowFiller(const Line& line, const TargetKind& kind, std::span<double> row)
      : line_(line), kind_(kind), row_(row) {}

  /// Comma-separated numbers. An empty cell of an optional column counts as not given. `column_of_cell`: of
  /// CSV; empty: the kind's order. Errors: number of cells; a cell that is not a number.
  void read_cells(std::span<const std::size_t> column_of_cell) {
    std::vector<std::string_view> cells;
    cells.reserve(kind_.columns.size());
    split_cells(line_.text, ',', cells);
    const std::size_t count = column_of_cell.size();
    if (count == 0) {
      check_count(0, cells.size(), kind_.form());
    } else if (cells.size() != count) {
      const bool surplus = cells.size() > count;
      line_.fail(surplus ? line_.offset_of(cells[count]) : line_.text.size(),
                 surplus ? "too many columns" : "too few columns", std::to_string(count),
                 std::to_string(cells.size()));
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::size_t column = count > 0 ? column_of_cell[i] : i, offset = line_.offset_of(cells[i]);
      if (cells[i].empty() && !kind_.columns[column].required) continue;
      const auto value = alidade::parse_number(cells[i]);
      if (!value) fail_invalid(column, offset, cells[i].empty() ? "nothing" : quote(cells[i]));
      put(column, offset, *value, [&] { return quote(cells[i]); });
    }
    check_row();
  }

  /// A line of JSON: an object whose keys are columns ("ox": 1) or vectors ("origin": [1, 2, 3]) of the kind,
  /// or an array in the kind's order. Values are numbers, "inf" or "-inf"; null counts as not given. Errors:
  /// no JSON (nested at most 64 deep, no key twice); an unknown key; a value given twice, or no number.
  void read_json() {
    const JsonDocument document = parse_document();
    const JsonValue& root = document.root;
    if (const auto* object = std::get_if<JsonObject>(&root.data)) {
      for (const JsonMember& member : *object) put_member(document, member);
    } else if (const auto* array = std::get_if<JsonArray>(&root.data)) {
      check_count(root.begin, array->size(), fmt::format("[{}]", kind_.form()));
      for (std::size_t i = 0; i < array->size(); ++i) put_json(document, (*array)[i], i);
    } else {
      line_.fail(root.begin, fmt::format("not a {}", kind_.name), "an object or an array",
                 document.quote(root.begin, root.end));
    }
    check_row();
  }

  /// The row holds the values of an array already.
  void check_array() {
    for (std::size_t i = 0; i < row_.size(); ++i)
      if (!std::isnan(row_[i])) put(i, 0, row_[i], [&] { return fmt::format("{}", row_[i]); });
    check_row();
  }

 private:
  void check_count(std::size_t offset, std::size_t count, const std::string& form) const {
    if (count < kind_.required_count() || count > kind_.columns.size())
      line_.fail(offset, fmt::format("not a {}", kind_.name), form,
                 fmt::format("{} value{}", count, count == 1 ? "" : "s"));
  }

  [[noreturn]] void fail_invalid(std::size_t column, std::size_t offset, const std::string& found) const {
    line_.fail(offset, fmt::format("invalid {}", kind_.columns[column].name), "a number", found);
  }

  /// `shown`: returns the value as written, at byte `offset`.
  template <class Shown>
  void put(std::size_t i, std::size_t offset, double value, const Shown& shown) {
    const TargetColumn& column = kind_.columns[i];
    offsets_[i] = offset;
    row_[i] = value;
    if (const char* const expected = expected_value(column.rule, value))
      line_.fail(offset, fmt::format("{} out of range", column.name), expected, shown());
  }

  void check_row() const {
    for (std::size_t i = 0; i < row_.size(); ++i) {
      if (kind_.columns[i].required && std::isnan(row_[i]))
        line_.fail(offsets_[i], fmt::format("missing value of {}", kind_.columns[i].name), kind_.form());
    }
    for (const TargetVector& vector : kind_.vectors) {
      const std::size_t x = vector.first;
      if (!vector.is_direction || row_[x] != 0.0 || row_[x + 1] != 0.0 || row_[x + 2] != 0.0) continue;
      line_.fail(offsets_[x], fmt::format("{} of the {} is zero", vector.name, kind_.name),
                 "a nonzero direction", "0,0,0");
    }
  }

  /// Errors get the line's own number.
  JsonDocument parse_document() const {
    try {
      return parse_json(std::string(line_.text), std::string(line_.source));
    } catch (const Error& error) {
      Error::Parts parts = error.parts();
      parts.location = fmt::format("{}{}", line_.number, parts.location.substr(parts.location.find(':')));
      throw Error(std::move(parts));
    }
  }

  void put_member(const JsonDocument& document, const JsonMember& member) {
    const std::size_t column = kind_.column(member.key);
    if (column < kind_.columns.size()) return put_json(document, member.value, column);
    const auto vector = std::ranges::find(kind_.vectors, std::string_view(member.key), &TargetVector::name);
    if (vector == kind_.vectors.end()) {
      std::string known = kind_.names();
      for (const TargetVector& other : kind_.vectors) known += fmt::format(", {}", other.name);
      line_.fail(member.key_begin, "unknown key " + document.quote(member.key_begin, member.key_end),
                 "one of " + known);
    }
    const auto* const array = std::get_if<JsonArray>(&member.value.data);
    if (array == nullptr || array->size() != 3) {
      line_.fail(member.value.begin, fmt::format("invalid {}", member.key), "an array of three numbers",
                 document.quote(member.value.begin, member.value.end));
    }
    for (std::size_t i = 0; i < 3; ++i) put_json(document, (*array)[i], vector->first + i);
  }

  void put_json(const JsonDocument& document, const JsonValue& value, std::size_t i) {
    const auto found = [&] { return document.quote(value.begin, value.end); };
    const auto set = [&](double number) { put(i, value.begin, number, [&] { return quote(found()); }); };
    if (!std::isnan(row_[i])) line_.fail(value.begin, fmt::format("duplicate {}", kind_.columns[i].name));
    if (std::holds_alternative<std::nullptr_t>(value.data) && !kind_.columns[i].required) return;
    if (const auto* real = std::get_if<double>(&value.data)) return set(*real);
    if (const auto* whole = std::get_if<std::uint64_t>(&value.data)) return set(static_cast<double>(*whole));
    const auto* const text = std::get_if<std::string>(&value.data);
    if (text != nullptr && *text == "inf") return set(k_infinity);
    if (text != nullptr && *text == "-inf") return set(-k_infinity);
    fail_invalid(i, value.begin, found());
  }

  const Line& line_;
  const TargetKind& kind_;
  std::span<double> row_;
  std::array<std::size_t, k_most_target_columns> offsets_{};  ///< of each column's value in the line
};

}  // namespace

/// Reads rows one after another, from blocks that are parsed in parallel.
class RowReader {
 public:
  RowReader(const GivenTargets& given, const TargetKind& kind, const std::function<bool()>& stops)
      : kind_(kind), stops_(stops), array_(given.rows.value_or(std::span<const double>())) {
    if (!given.text.empty()) {
      open(given.text);
    } else if (!given.values.empty()) {
      source_ = Source::option;
      name_ = kind.value_option;
      for (const std::string& value : given.values) waiting_ += value + "\n";
    } else {
      source_ = Source::array;
      name_ = kind.plural;
      total_ = array_.size();
      if (array_.size() % kind.columns.size() != 0)
        throw input_error(fmt::format("not an array of {}", kind.plural), kind.form());
    }
    if (source_ != Source::array) begin();
  }

  const TargetKind& kind() const { return kind_; }

  /// The next row, valid until the next call; empty at the end.
  std::span<const double> next() {
    while (used_ == numbers_.size()) {
      if (source_ == Source::array ? !next_part() : !next_rows()) return {};
    }
    return std::span(values_).subspan(used_++ * kind_.columns.size(), kind_.columns.size());
  }

  /// Number of the row that was read last: its line, from 1; of arrays from 0.
  std::uint64_t number() const { return numbers_[used_ - 1]; }

  double share() const {
    if (total_ == 0) return 0.0;
    const double used =
        numbers_.empty() ? 1.0 : static_cast<double>(used_) / static_cast<double>(numbers_.size());
    return (static_cast<double>(done_) - (1.0 - used) * static_cast<double>(size_)) /
           static_cast<double>(total_);
  }

  /// Throws an Error of the rows from this one on as a whole.
  [[noreturn]] void fail(std::uint64_t number, const Error::Parts& parts) const {
    Line{.source = name_, .kind = source_, .number = number}.fail(0, parts.problem, parts.expected,
                                                                  parts.found);
  }

 private:
  static constexpr int k_wait_milliseconds = 100;
  static constexpr std::size_t k_block_bytes = 1 << 20, k_block_rows = 1 << 14, k_rows_at_once = 512;

  void open(const std::string& name) {
    const bool is_input = name == "-";
    name_ = is_input ? "standard input" : name;
    descriptor_ = FileDescriptor(is_input ? ::dup(STDIN_FILENO) : ::open(name.c_str(), O_RDONLY | O_CLOEXEC));
    if (!is_input && !descriptor_.is_open()) throw system_error(name, "cannot open the file");
    struct stat status {};
    if (!is_input && ::fstat(descriptor_.number(), &status) == 0 && S_ISREG(status.st_mode))
      total_ = static_cast<std::uint64_t>(status.st_size);
  }

  /// Finds the first line that is not blank, and reads the header of CSV.
  void begin() {
    while (next_lines()) {
      const auto first =
          std::ranges::find_if(lines_, [](const Line& one) { return !trim(one.text).empty(); });
      lines_.erase(lines_.begin(), first);
      if (lines_.empty()) continue;
      has_lines_ = true;
      if (source_ == Source::option) return;
      const char character = trim(lines_.front().text).front();
      is_json_ = character == '{' || character == '[';
      if (is_json_) return;
      column_of_cell_ = read_header(lines_.front(), kind_);
      lines_.erase(lines_.begin());
      return;
    }
    fail(1, {.problem = fmt::format("contains no {}", kind_.plural),
             .expected = fmt::format("CSV with the header {}, or JSON lines", kind_.form()),
             .found = "nothing"});
  }

  /// Fills up `waiting_`; false at the end.
  bool read_more() {
    if (!descriptor_.is_open()) return false;
    const std::size_t before = waiting_.size();
    std::size_t have = before;
    waiting_.resize(before + k_block_bytes);
    while (have < waiting_.size()) {
      if (stops_ && stops_()) throw Cancelled();
      // The signal that stops the job may reach another thread than this one.
      pollfd input{.fd = descriptor_.number(), .events = POLLIN, .revents = 0};
      const int ready = ::poll(&input, 1, k_wait_milliseconds);
      if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
      const ::ssize_t count = ::read(descriptor_.number(), waiting_.data() + have, waiting_.size() - have);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) throw system_error(name_, "cannot read the file");
      if (count == 0) break;
      have += static_cast<std::size_t>(count);
    }
    waiting_.resize(have);
    return have > before;
  }

  /// Reads whole lines, about a mebibyte of them, without a byte order mark; false at the end.
  bool next_lines() {
    lines_.clear();
    const bool more = read_more();
    if (done_ == 0 && waiting_.starts_with(k_byte_order_mark)) waiting_.erase(0, k_byte_order_mark.size());
    if (waiting_.empty()) return false;
    // At the end of the text the last line may lack its end.
    const std::size_t last_end = waiting_.rfind('\n');
    if (more && last_end == std::string::npos && waiting_.size() >= k_block_bytes)
      fail(next_number_,
           {.problem = "line too long", .expected = fmt::format("at most {} bytes", k_block_bytes)});
    size_ = last_end == std::string::npos ? waiting_.size() : last_end + 1;
    std::string rest = waiting_.substr(size_);
    waiting_.resize(size_);
    text_ = std::exchange(waiting_, std::move(rest));
    for (std::size_t begin = 0; begin < text_.size();) {
      const std::size_t end = std::min(text_.find('\n', begin), text_.size());
      const bool has_return = end > begin && text_[end - 1] == '\r';
      lines_.push_back({.source = name_,
                        .kind = source_,
                        .text = std::string_view(text_).substr(begin, end - begin - (has_return ? 1 : 0)),
                        .number = next_number_++});
      begin = end + 1;
    }
    done_ += size_;
    return true;
  }

  /// The rows of the next lines, maybe none; false at the end.
  bool next_rows() {
    if (!std::exchange(has_lines_, false) && !next_lines()) return false;
    std::erase_if(lines_, [](const Line& line) { return trim(line.text).empty(); });
    start_rows(lines_.size());
    const std::size_t width = kind_.columns.size();
    values_.assign(lines_.size() * width, k_not_given);
    in_parallel(lines_.size(), k_rows_at_once, [&](std::size_t i) {
      const std::span<double> row = std::span(values_).subspan(i * width, width);
      RowFiller filler(lines_[i], kind_, row);
      is_json_ ? filler.read_json() : filler.read_cells(column_of_cell_);
      numbers_[i] = lines_[i].number;
    });
    return true;
  }

  /// The next rows of an array; false at the end.
  bool next_part() {
    const std::size_t width = kind_.columns.size();
    size_ = std::min(k_block_rows * width, array_.size() - done_);
    const std::span<const double> part = array_.subspan(done_, size_);
    values_.assign(part.begin(), part.end());
    start_rows(size_ / width);
    in_parallel(numbers_.size(), k_rows_at_once, [&](std::size_t i) {
      numbers_[i] = done_ / width + i;
      const Line line{.source = name_, .kind = source_, .number = numbers_[i]};
      RowFiller(line, kind_, std::span(values_).subspan(i * width, width)).check_array();
    });
    done_ += size_;
    return size_ > 0;
  }

  void start_rows(std::size_t count) {
    used_ = 0;
    numbers_.resize(count);
  }

  const TargetKind& kind_;
  std::function<bool()> stops_;
  Source source_ = Source::text;
  std::string name_;  ///< in messages
  FileDescriptor descriptor_;
  std::span<const double> array_;
  std::string waiting_;  ///< text that is read, but not yet in `lines_`
  std::uint64_t next_number_ = 1;
  std::uint64_t done_ = 0, total_ = 0;  ///< bytes of lines, or numbers; `total_` is 0 if it is not known
  bool is_json_ = false, has_lines_ = false;
  std::vector<std::size_t> column_of_cell_;  ///< of CSV
  // The block that is being used.
  std::string text_;
  std::vector<Line> lines_;
  std::size_t size_ = 0;                ///< bytes, or numbers
  std::vector<double> values_;          ///< of all rows
  std::vector<std::uint64_t> numbers_;  ///< of each row
  std::size_t used_ = 0;                ///< rows
};

namespace {

template <class Target>
constexpr bool is_group = std::is_same_v<Target, Path> || std::is_same_v<Target, HalfSpaces>;

glm::dvec3 vector_at(std::span<const double> row, std::size_t first) {
  return {row[first], row[first + 1], row[first + 2]};
}

/// A value that was given, else the option's, else the usual one.
double value_or(double given, const std::optional<double>& option, double usual) {
  return std::isnan(given) ? option.value_or(usual) : given;
}

template <class Target>
Target made(std::span<const double> row, const CheckedQuery& query) {
  if constexpr (std::is_same_v<Target, Ray>) {
    return make_ray(vector_at(row, 0), vector_at(row, 3), value_or(row[6], query.t_min, -k_infinity),
                    value_or(row[7], query.t_max, k_infinity));
  } else if constexpr (std::is_same_v<Target, Cone>) {
    const double half_angle = row[6] * (std::acos(-1.0) / 180.0);
    return make_cone(vector_at(row, 0), vector_at(row, 3), half_angle, value_or(row[7], {}, 0.0),
                     value_or(row[8], query.t_min, 0.0), value_or(row[9], query.t_max, k_infinity));
  } else if constexpr (std::is_same_v<Target, Bounds>) {
    return {vector_at(row, 0), vector_at(row, 3)};
  } else {
    return vector_at(row, 0);
  }
}

/// Returns what make() returns; adds the row's number to its errors.
template <class Make>
auto made_of_row(const RowReader& rows, std::uint64_t number, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    rows.fail(number, error.parts());
  }
}

}  // namespace

template <class Target>
TargetReader<Target>::TargetReader(const CheckedQuery& query, const std::function<bool()>& stops)
    : rows_(std::make_unique<RowReader>(query.given_targets(), target_kind(query.family), stops)),
      query_(query) {}

template <class Target>
TargetReader<Target>::~TargetReader() = default;

template <class Target>
bool TargetReader<Target>::next(std::size_t most, TargetBatch<Target>& batch) {
  batch.targets.clear();
  batch.ids.clear();
  while (batch.targets.size() < most) {
    const std::span<const double> row = rows_->next();
    if (row.empty()) {
      end_group(batch);
      break;
    }
    take_row(row, batch);
  }
  return !batch.targets.empty();
}

template <class Target>
double TargetReader<Target>::share() const {
  return rows_->share();
}

template <class Target>
void TargetReader<Target>::take_row(std::span<const double> row, TargetBatch<Target>& batch) {
  if constexpr (is_group<Target>) {
    const std::uint64_t group = std::isnan(row.back()) ? 0 : static_cast<std::uint64_t>(row.back());
    if (group_ && group < *group_) {
      rows_->fail(rows_->number(),
                  {.problem = fmt::format("{} numbers are not in ascending order", rows_->kind().name),
                   .expected = "rows sorted by number",
                   .found = fmt::format("{}", group)});
    }
    if (group_ != group) {
      end_group(batch);
      group_ = group;
      group_line_ = rows_->number();
    }
    if constexpr (std::is_same_v<Target, Path>) {
      vertices_.push_back(vector_at(row, 0));
    } else {
      planes_.push_back(made_of_row(*rows_, rows_->number(),
                                    [&] { return make_plane(vector_at(row, 0), vector_at(row, 3)); }));
    }
  } else {
    batch.targets.push_back(made_of_row(*rows_, rows_->number(), [&] { return made<Target>(row, query_); }));
    batch.ids.push_back(next_id_++);
  }
}

template <class Target>
void TargetReader<Target>::end_group(TargetBatch<Target>& batch) {
  if constexpr (is_group<Target>) {
    if (!group_) return;
    if constexpr (std::is_same_v<Target, Path>) {
      batch.targets.push_back(made_of_row(*rows_, group_line_, [&] {
        return make_path(vertices_, query_.t_min.value_or(-k_infinity), query_.t_max.value_or(k_infinity));
      }));
      vertices_.clear();
    } else {
      batch.targets.push_back({std::move(planes_)});
      planes_.clear();
    }
    batch.ids.push_back(*group_);
    group_.reset();
  }
}

template class TargetReader<Ray>;
template class TargetReader<Cone>;
template class TargetReader<Path>;
template class TargetReader<HalfSpaces>;
template class TargetReader<Bounds>;
template class TargetReader<glm::dvec3>;

}  // namespace alidade::jobs
