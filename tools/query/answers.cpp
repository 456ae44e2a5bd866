// SPDX-License-Identifier: MIT
#include <tbb/parallel_for.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "tools/cloud/write_points.h"
#include "tools/console.h"
#include "tools/query/answers.h"

namespace alidade::tools {
namespace {

constexpr std::size_t k_rows_per_text = 1024;

void add(std::string& text, std::uint64_t value) {
  char digits[20];
  text.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

void add(std::string& text, double value) {
  char digits[32];
  text.append(digits,
              std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 17).ptr);
}

void add_value(std::string& text, const AnswerColumn& column, const AnswerRow& row, TextForm form) {
  if (column.whole != nullptr) return add(text, row.*column.whole);
  const double value = column.real != nullptr ? row.*column.real : row.position[column.axis];
  if (form == TextForm::json_lines && !std::isfinite(value)) {
    text += "null";
  } else {
    add(text, value);
  }
}

void add_row(std::string& text, const std::vector<AnswerColumn>& columns, const AnswerRow& row,
             TextForm form) {
  const bool json = form == TextForm::json_lines;
  char separator = json ? '{' : '\0';
  for (const AnswerColumn& column : columns) {
    if (separator != '\0') text += separator;
    separator = ',';
    if (json) text.append("\"").append(column.name).append("\":");
    add_value(text, column, row, form);
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

/// Calls work(i) for every row, in parallel.
template <class Work>
void for_each_row(std::size_t count, const Work& work) {
  tbb::parallel_for(std::size_t{0}, (count + k_rows_per_task - 1) / k_rows_per_task, [&](std::size_t part) {
    for (std::size_t i = part * k_rows_per_task; i < std::min((part + 1) * k_rows_per_task, count); ++i)
      work(i);
  });
}

/// The step a position stands on. Exact: positions were computed from steps, and lie closer to them than to others.
LatticePosition steps_of(const Lattice& lattice, const glm::dvec3& position) {
  const auto steps = to_lattice(lattice, position);
  if (!steps) throw Error({.problem = "position of a point does not stand on the cloud's lattice"});
  return *steps;
}

}  // namespace

AnswerText::AnswerText(std::vector<AnswerColumn> columns, TextForm form, std::unique_ptr<OutputFile> file)
    : columns_(std::move(columns)), form_(form), file_(std::move(file)) {
  if (form_ == TextForm::json_lines) return;
  for (const AnswerColumn& column : columns_) header_ += (header_.empty() ? "" : ",") + column.name;
  header_ += "\n";
}

void AnswerText::put(const std::string& text) {
  if (file_) {
    file_->write(std::as_bytes(std::span(text)));
  } else {
    write_to_stdout(text);
  }
}

void AnswerText::put_header() {
  put(std::exchange(header_, {}));
}

void AnswerText::write(const AnswerRows& rows) {
  put_header();
  for (std::size_t begin = 0; begin < rows.size; begin += k_rows_at_once) {
    const std::size_t end = std::min(begin + k_rows_at_once, rows.size);
    std::vector<std::string> parts((end - begin + k_rows_per_text - 1) / k_rows_per_text);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
      const std::size_t first = begin + p * k_rows_per_text;
      std::vector<AnswerRow> part_rows(std::min(k_rows_per_text, end - first));
      rows.fill(first, part_rows);
      parts[p].reserve(part_rows.size() * 24 * columns_.size());
      for (const AnswerRow& row : part_rows) add_row(parts[p], columns_, row, form_);
    });
    for (const std::string& part : parts) put(part);
  }
}

void AnswerText::finish() {
  put_header();
  if (file_) file_->commit();
}

AnswerLas::AnswerLas(const std::filesystem::path& file, bool overwrite, const IndexedCloud& cloud,
                     std::vector<AnswerDimension> dimensions)
    : cloud_(cloud), columns_(cloud.columns()), dimensions_(std::move(dimensions)) {
  std::erase_if(columns_.extra_dimensions, [&](const ExtraColumn& column) {
    const std::string& name = column.description.name;
    if (std::ranges::find(dimensions_, name, &AnswerDimension::name) == dimensions_.end()) return false;
    replaced_.push_back(name);
    return true;
  });
  PointCloud like = description_of(cloud);
  for (const ExtraColumn& column : columns_.extra_dimensions)
    like.extra_dimensions.push_back(column.description);
  for (const AnswerDimension& dimension : dimensions_) like.extra_dimensions.push_back(described(dimension));
  LasWriteOptions options;
  options.overwrite = overwrite;
  writer_ = std::make_unique<LasWriter>(file, like, columns_.attributes(), options);
}

PointCloud AnswerLas::points(std::span<const AnswerRow> rows) const {
  PointCloud batch;
  batch.lattice = cloud_.octree.lattice();
  batch.positions.resize(rows.size());
  for_each_row(rows.size(),
               [&](std::size_t i) { batch.positions[i] = steps_of(batch.lattice, rows[i].position); });
  for_each_column(batch, columns_, [&](Attribute, auto& column, const auto& all) {
    if (all.empty()) return;
    column.resize(rows.size());
    for_each_row(rows.size(), [&](std::size_t i) { column[i] = all[rows[i].point_id]; });
  });
  for (const ExtraColumn& column : columns_.extra_dimensions) {
    ExtraDimension& extra = batch.extra_dimensions.emplace_back(column.description);
    const auto bytes = static_cast<std::size_t>(extra.byte_count);
    extra.values.resize(rows.size() * bytes);
    for_each_row(rows.size(), [&](std::size_t i) {
      std::memcpy(extra.values.data() + i * bytes, column.values.data() + rows[i].point_id * bytes, bytes);
    });
  }
  for (const AnswerDimension& dimension : dimensions_) {
    ExtraDimension& extra = batch.extra_dimensions.emplace_back(described(dimension));
    extra.values.resize(rows.size() * 8);
    for_each_row(rows.size(), [&](std::size_t i) {
      const void* const value = dimension.whole != nullptr
                                    ? static_cast<const void*>(&(rows[i].*dimension.whole))
                                    : &(rows[i].*dimension.real);
      std::memcpy(extra.values.data() + i * 8, value, 8);
    });
  }
  return batch;
}

void AnswerLas::write(const AnswerRows& rows) {
  std::vector<AnswerRow> block;
  for (std::size_t first = 0; first < rows.size; first += k_rows_at_once) {
    block.assign(std::min(k_rows_at_once, rows.size - first), {});
    rows.fill(first, block);
    writer_->write(points(block));
  }
}

void AnswerLas::finish() {
  writer_->finish();
}

}  // namespace alidade::tools
