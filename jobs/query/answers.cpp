// SPDX-License-Identifier: MIT
#include "jobs/query/answers.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/parallel.h"
#include "cloud/las/write_las.h"
#include "jobs/write_points.h"

namespace alidade::jobs {
namespace {

constexpr std::size_t k_rows_per_text = 1024;

void add(std::string& text, std::uint64_t value) {
  char digits[20];
  text.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

void add(std::string& text, double value, std::optional<int> digits) {
  char written[32];
  const auto end = digits ? std::to_chars(std::begin(written), std::end(written), value,
                                          std::chars_format::general, *digits)
                          : std::to_chars(std::begin(written), std::end(written), value);
  text.append(written, end.ptr);
}

/// Rounded to so many decimals, without zeros at the end.
void add_rounded(std::string& text, double value, int decimals) {
  char written[64];
  char* end = fmt::format_to_n(written, std::size(written), "{:.{}f}", value, decimals).out;
  if (decimals > 0) {
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
  }
  const std::string_view digits(written, end);
  text += digits == "-0" ? "0" : digits;
}

constexpr std::size_t k_rows_per_task = 4096;

ExtraDimension described(const AnswerColumn& column) {
  ExtraDimension extra;
  extra.name = column.dimension;
  extra.description = column.description;
  extra.type = column.whole != nullptr ? ScalarType::uint64 : ScalarType::float64;
  return extra;
}

/// The lattice position that a world position was computed from. Exact: no other one is closer.
LatticePosition steps_of(const Lattice& lattice, const glm::dvec3& position) {
  const auto steps = to_lattice(lattice, position);
  if (!steps) throw Error({.problem = "the position of a point is not on the cloud's lattice"});
  return *steps;
}

class AnswerText final : public AnswerOutput {
 public:
  AnswerText(const CheckedQuery& query, const Lattice& lattice)
      : columns_(answer_columns(query)),
        is_json_(query.form == AnswerForm::json_lines),
        digits_(query.precision),
        take_(query.write_text) {
    for (int axis = 0; axis < 3 && !digits_; ++axis)
      decimals_[static_cast<std::size_t>(axis)] = shown_decimals(lattice, axis);
    if (!query.output.empty()) {
      file_ = std::make_unique<OutputFile>(query.output, query.overwrite);
      take_ = [this](std::string_view text) { file_->write(text); };
    }
    if (is_json_) return;
    for (const AnswerColumn& column : columns_) header_ += (header_.empty() ? "" : ",") + column.name;
    header_ += "\n";
  }

  void write(std::span<const AnswerRow> rows) override {
    put_header();
    std::vector<std::string> parts((rows.size() + k_rows_per_text - 1) / k_rows_per_text);
    in_blocks(rows.size(), k_rows_per_text, [&](std::size_t first, std::size_t last) {
      std::string& part = parts[first / k_rows_per_text];
      part.reserve((last - first) * 24 * columns_.size());
      for (std::size_t i = first; i < last; ++i) add_row(part, rows[i]);
    });
    for (const std::string& part : parts) take_(part);
  }

  void finish() override {
    put_header();
    if (file_) file_->commit();
  }

 private:
  void put_header() { take_(std::exchange(header_, {})); }

  void add_row(std::string& text, const AnswerRow& row) const {
    char separator = is_json_ ? '{' : '\0';
    for (const AnswerColumn& column : columns_) {
      if (separator != '\0') text += separator;
      separator = ',';
      if (is_json_) text.append("\"").append(column.name).append("\":");
      add_value(text, column, row);
    }
    text += is_json_ ? "}\n" : "\n";
  }

  void add_value(std::string& text, const AnswerColumn& column, const AnswerRow& row) const {
    if (column.whole != nullptr) return add(text, row.*column.whole);
    const double value = column.real != nullptr ? row.*column.real : row.position[column.axis];
    const auto& decimals = decimals_[static_cast<std::size_t>(column.axis)];
    if (is_json_ && !std::isfinite(value)) {
      text += "null";
    } else if (column.real == nullptr && decimals) {
      add_rounded(text, value, *decimals);
    } else {
      add(text, value, digits_);
    }
  }

  std::vector<AnswerColumn> columns_;
  bool is_json_;
  std::optional<int> digits_;                     ///< empty: as many as give the same number again
  std::array<std::optional<int>, 3> decimals_{};  ///< of coordinates; empty: as other numbers
  std::string header_;  ///< until it is written: with the first rows, so that bad targets leave stdout empty
  std::unique_ptr<OutputFile> file_;
  std::function<void(std::string_view)> take_;
};

class AnswerLas final : public AnswerOutput {
 public:
  AnswerLas(const CheckedQuery& query, const IndexedCloud& cloud, Listener& listener)
      : cloud_(cloud), columns_(cloud.columns()), results_(answer_columns(query)) {
    std::erase_if(results_, [](const AnswerColumn& column) { return column.dimension.empty(); });
    // Readers rely on Distance, RayT, RayId.
    std::ranges::reverse(results_);
    std::vector<std::string> warnings;
    std::erase_if(columns_.extra_dimensions, [&](const ExtraColumn& column) {
      const std::string& name = column.description.name;
      if (std::ranges::find(results_, name, &AnswerColumn::dimension) == results_.end()) return false;
      warnings.push_back(fmt::format("{}: replacing the cloud's {}", query.output.string(), name));
      return true;
    });
    PointCloud like = description_of(cloud);
    for (const ExtraColumn& column : columns_.extra_dimensions)
      like.extra_dimensions.push_back(column.description);
    for (const AnswerColumn& result : results_) like.extra_dimensions.push_back(described(result));
    writer_.emplace(query.output, like, columns_.attributes(),
                    LasWriteOptions{.overwrite = query.overwrite,
                                    .warn = [&](const std::string& text) { warnings.push_back(text); }});
    warn_all(listener, warnings);
  }

  void write(std::span<const AnswerRow> rows) override {
    if (rows.empty()) return;
    PointCloud batch;
    batch.lattice = cloud_.octree.lattice();
    batch.positions.resize(rows.size());
    const auto for_each_row = [&](const auto& work) { in_parallel(rows.size(), k_rows_per_task, work); };
    for_each_row([&](std::size_t i) { batch.positions[i] = steps_of(batch.lattice, rows[i].position); });
    for_each_column(batch, columns_, [&](Attribute, auto& column, const auto& all) {
      if (all.empty()) return;
      column.resize(rows.size());
      for_each_row([&](std::size_t i) { column[i] = all[rows[i].point_id]; });
    });
    for (const ExtraColumn& column : columns_.extra_dimensions) {
      const auto bytes = static_cast<std::size_t>(column.description.byte_count);
      std::uint8_t* const values = add_dimension(batch, column.description, rows.size() * bytes);
      for_each_row([&](std::size_t i) {
        std::memcpy(values + i * bytes, column.values.data() + rows[i].point_id * bytes, bytes);
      });
    }
    for (const AnswerColumn& result : results_) {
      std::uint8_t* const values = add_dimension(batch, described(result), rows.size() * 8);
      for_each_row([&](std::size_t i) {
        const void* const value = result.whole != nullptr ? static_cast<const void*>(&(rows[i].*result.whole))
                                                          : &(rows[i].*result.real);
        std::memcpy(values + i * 8, value, 8);
      });
    }
    writer_->write(batch);
  }

  void finish() override { writer_->finish(); }

 private:
  static std::uint8_t* add_dimension(PointCloud& batch, const ExtraDimension& like, std::size_t bytes) {
    ExtraDimension& extra = batch.extra_dimensions.emplace_back(like);
    extra.values.resize(bytes);
    return extra.values.data();
  }

  const IndexedCloud& cloud_;
  AttributeColumns columns_;  ///< without those that are left out
  std::vector<AnswerColumn> results_;
  std::optional<LasWriter> writer_;
};

}  // namespace

std::vector<AnswerColumn> answer_columns(const CheckedQuery& query) {
  using enum TargetFamily;
  const TargetFamily family = query.family;
  const bool is_straight = family == rays || family == lines || family == cones;
  const TargetKind& kind = target_kind(family);
  const std::string id(kind.id_name), dimension(kind.dimension);
  if (query.has_only_numbers())
    return {{.name = id, .whole = &AnswerRow::target_id},
            {.name = query.occluded ? "occluded" : "count", .whole = &AnswerRow::count}};
  std::vector<AnswerColumn> columns = {{.name = id,
                                        .whole = &AnswerRow::target_id,
                                        .dimension = dimension + "Id",
                                        .description = "index of the target"},
                                       {.name = "rank", .whole = &AnswerRow::rank},
                                       {.name = "point_id", .whole = &AnswerRow::point_id},
                                       {.name = "x", .axis = 0},
                                       {.name = "y", .axis = 1},
                                       {.name = "z", .axis = 2}};
  if (family == path) columns.push_back({.name = "segment", .whole = &AnswerRow::segment});
  if (is_straight || family == path)
    columns.push_back({.name = "t",
                       .real = &AnswerRow::t,
                       .dimension = dimension + "T",
                       .description = "position along the target"});
  if (family != boxes)
    columns.push_back({.name = "distance",
                       .real = &AnswerRow::distance,
                       .dimension = "Distance",
                       .description = "distance to the target"});
  if (is_straight) columns.push_back({.name = "entry", .real = &AnswerRow::entry});
  return columns;
}

std::unique_ptr<AnswerOutput> open_text(const CheckedQuery& query, const Lattice& lattice) {
  return std::make_unique<AnswerText>(query, lattice);
}

std::unique_ptr<AnswerOutput> open_las(const CheckedQuery& query, const IndexedCloud& cloud,
                                       Listener& listener) {
  return std::make_unique<AnswerLas>(query, cloud, listener);
}

}  // namespace alidade::jobs
