// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>

#include "base/parallel.h"
#include "jobs/write_points.h"
#include "tools/query/answers.h"

namespace alidade::tools {
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

void add_value(std::string& text, const AnswerColumn& column, const AnswerRow& row, AnswerForm form,
               const NumberForm& numbers) {
  if (column.whole != nullptr) return add(text, row.*column.whole);
  const double value = column.real != nullptr ? row.*column.real : row.position[column.axis];
  const auto& decimals = numbers.decimals[static_cast<std::size_t>(column.axis)];
  if (form == AnswerForm::json_lines && !std::isfinite(value)) {
    text += "null";
  } else if (column.real == nullptr && decimals) {
    add_rounded(text, value, *decimals);
  } else {
    add(text, value, numbers.digits);
  }
}

void add_row(std::string& text, const std::vector<AnswerColumn>& columns, const AnswerRow& row,
             AnswerForm form, const NumberForm& numbers) {
  const bool json = form == AnswerForm::json_lines;
  char separator = json ? '{' : '\0';
  for (const AnswerColumn& column : columns) {
    if (separator != '\0') text += separator;
    separator = ',';
    if (json) text.append("\"").append(column.name).append("\":");
    add_value(text, column, row, form, numbers);
  }
  text += json ? "}\n" : "\n";
}

constexpr std::size_t k_rows_per_task = 4096;

ExtraDimension described(const AnswerDimension& dimension) {
  ExtraDimension extra;
  extra.name = dimension.name;
  extra.description = dimension.description;
  extra.type = dimension.whole != nullptr ? ScalarType::uint64 : ScalarType::float64;
  return extra;
}

/// The lattice position that a world position was computed from. Exact: no other one is closer.
LatticePosition steps_of(const Lattice& lattice, const glm::dvec3& position) {
  const auto steps = to_lattice(lattice, position);
  if (!steps) throw Error({.problem = "the position of a point is not on the cloud's lattice"});
  return *steps;
}

/// Rows of an AnswerRows in memory at once: bounds memory whatever the number of answers.
constexpr std::size_t k_rows_per_write = 1 << 17;

class AnswerText final : public AnswerOutput {
 public:
  AnswerText(std::vector<AnswerColumn> columns, AnswerForm form, const NumberForm& numbers,
             std::unique_ptr<OutputFile> file)
      : columns_(std::move(columns)), form_(form), numbers_(numbers), file_(std::move(file)) {
    if (form_ == AnswerForm::json_lines) return;
    for (const AnswerColumn& column : columns_) header_ += (header_.empty() ? "" : ",") + column.name;
    header_ += "\n";
  }

  void write(const AnswerRows& rows) override {
    put_header();
    for (std::size_t begin = 0; begin < rows.size; begin += k_rows_per_write) {
      const std::size_t end = std::min(begin + k_rows_per_write, rows.size);
      std::vector<std::string> parts((end - begin + k_rows_per_text - 1) / k_rows_per_text);
      in_blocks(end - begin, k_rows_per_text, [&](std::size_t first, std::size_t last) {
        std::string& part = parts[first / k_rows_per_text];
        std::vector<AnswerRow> part_rows(last - first);
        rows.fill(begin + first, part_rows);
        part.reserve(part_rows.size() * 24 * columns_.size());
        for (const AnswerRow& row : part_rows) add_row(part, columns_, row, form_, numbers_);
      });
      for (const std::string& part : parts) put(part);
    }
  }

  void finish() override {
    put_header();
    if (file_) file_->commit();
  }

 private:
  void put(const std::string& text) {
    if (file_) {
      file_->write(text);
    } else {
      write_to_stdout(text);
    }
  }

  void put_header() { put(std::exchange(header_, {})); }

  std::vector<AnswerColumn> columns_;
  AnswerForm form_;
  NumberForm numbers_;
  std::string header_;  ///< until it is written: with the first rows, so that bad targets leave stdout empty
  std::unique_ptr<OutputFile> file_;
};

class AnswerLas final : public AnswerOutput {
 public:
  AnswerLas(const std::filesystem::path& file, bool overwrite, const IndexedCloud& cloud,
            std::vector<AnswerDimension> dimensions, Verbosity verbosity)
      : cloud_(cloud), columns_(cloud.columns()), dimensions_(std::move(dimensions)) {
    std::vector<std::string> warnings;
    std::erase_if(columns_.extra_dimensions, [&](const ExtraColumn& column) {
      const std::string& name = column.description.name;
      if (std::ranges::find(dimensions_, name, &AnswerDimension::name) == dimensions_.end()) return false;
      warnings.push_back(fmt::format("{}: replacing the cloud's {}", file.string(), name));
      return true;
    });
    PointCloud like = jobs::description_of(cloud);
    for (const ExtraColumn& column : columns_.extra_dimensions)
      like.extra_dimensions.push_back(column.description);
    for (const AnswerDimension& dimension : dimensions_)
      like.extra_dimensions.push_back(described(dimension));
    writer_.emplace(file, like, columns_.attributes(),
                    LasWriteOptions{.overwrite = overwrite,
                                    .warn = [&](const std::string& text) { warnings.push_back(text); }});
    say_warnings(verbosity, warnings);
  }

  void write(const AnswerRows& rows) override {
    std::vector<AnswerRow> block;
    for (std::size_t first = 0; first < rows.size; first += k_rows_per_write) {
      block.assign(std::min(k_rows_per_write, rows.size - first), {});
      rows.fill(first, block);
      writer_->write(points(block));
    }
  }

  void finish() override { writer_->finish(); }

 private:
  PointCloud points(std::span<const AnswerRow> rows) const {
    PointCloud batch;
    batch.lattice = cloud_.octree.lattice();
    batch.positions.resize(rows.size());
    in_parallel(rows.size(), k_rows_per_task,
                [&](std::size_t i) { batch.positions[i] = steps_of(batch.lattice, rows[i].position); });
    for_each_column(batch, columns_, [&](Attribute, auto& column, const auto& all) {
      if (all.empty()) return;
      column.resize(rows.size());
      in_parallel(rows.size(), k_rows_per_task, [&](std::size_t i) { column[i] = all[rows[i].point_id]; });
    });
    for (const ExtraColumn& column : columns_.extra_dimensions) {
      ExtraDimension& extra = batch.extra_dimensions.emplace_back(column.description);
      const auto bytes = static_cast<std::size_t>(extra.byte_count);
      extra.values.resize(rows.size() * bytes);
      in_parallel(rows.size(), k_rows_per_task, [&](std::size_t i) {
        std::memcpy(extra.values.data() + i * bytes, column.values.data() + rows[i].point_id * bytes, bytes);
      });
    }
    for (const AnswerDimension& dimension : dimensions_) {
      ExtraDimension& extra = batch.extra_dimensions.emplace_back(described(dimension));
      extra.values.resize(rows.size() * 8);
      in_parallel(rows.size(), k_rows_per_task, [&](std::size_t i) {
        const void* const value = dimension.whole != nullptr
                                      ? static_cast<const void*>(&(rows[i].*dimension.whole))
                                      : &(rows[i].*dimension.real);
        std::memcpy(extra.values.data() + i * 8, value, 8);
      });
    }
    return batch;
  }

  const IndexedCloud& cloud_;
  AttributeColumns columns_;  ///< without those that are left out
  std::vector<AnswerDimension> dimensions_;
  std::optional<LasWriter> writer_;
};

}  // namespace

std::unique_ptr<AnswerOutput> answers_as_text(std::vector<AnswerColumn> columns, AnswerForm form,
                                              const NumberForm& numbers, std::unique_ptr<OutputFile> file) {
  return std::make_unique<AnswerText>(std::move(columns), form, numbers, std::move(file));
}

std::unique_ptr<AnswerOutput> answers_as_las(const std::filesystem::path& file, bool overwrite,
                                             const IndexedCloud& cloud,
                                             std::vector<AnswerDimension> dimensions, Verbosity verbosity) {
  return std::make_unique<AnswerLas>(file, overwrite, cloud, std::move(dimensions), verbosity);
}

}  // namespace alidade::tools
