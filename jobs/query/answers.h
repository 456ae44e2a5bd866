// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/listener.h"
#include "jobs/query/target_kind.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// A row of the answer to any query. A family fills what it has.
struct AnswerRow {
  std::uint64_t target_id = 0;
  std::uint64_t rank = 0;  ///< among the target's answers, from 0
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  std::uint64_t segment = 0;
  double t = 0.0, distance = 0.0, entry = 0.0;
  std::uint64_t count = 0;  ///< of queries for a number alone; of `occluded` 0 or 1
};

/// A column of the answer: its name and the member that holds its value.
struct AnswerColumn {
  std::string name;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< one of these two, or else an axis of the position
  double AnswerRow::*real = nullptr;
  int axis = 0;
  std::string dimension{};  ///< name as an extra dimension of LAS; empty: none
  const char* description = "";
};

/// Columns of found points.
std::vector<AnswerColumn> answer_columns(TargetFamily family);

/// Columns of queries for a number alone, which is called `name`.
std::vector<AnswerColumn> number_columns(TargetFamily family, const std::string& name);

/// How numbers that are not whole are written.
struct NumberForm {
  std::array<std::optional<int>, 3> decimals{};  ///< of coordinates; empty: as other numbers
  std::optional<int> digits{};                   ///< of others; empty: as many as give the same number again
};

enum class AnswerForm {
  csv,         ///< a header and a line per row; infinite numbers are "inf" and "-inf"
  json_lines,  ///< an object per row; numbers as in csv, null for infinite ones
  las,         ///< found points
};

/// Where answers go, in their order.
class AnswerOutput {
 public:
  virtual ~AnswerOutput() = default;
  /// Errors: no space, and other failures to write.
  virtual void write(std::span<const AnswerRow> rows) = 0;
  /// Ends the output; files appear under their name only here.
  virtual void finish() = 0;
};

/// An output file that is not LAS, or, if it has no name, what takes a text in pieces.
struct TextOutput {
  std::filesystem::path file{};
  bool overwrite = false;
  std::function<void(std::string_view)> take{};
};

/// Answers as text of the form. Formats rows in parallel. Errors: OutputFile's.
std::unique_ptr<AnswerOutput> answers_as_text(std::vector<AnswerColumn> columns, AnswerForm form,
                                              const NumberForm& numbers, const TextOutput& output);

/// Found points as LAS 1.4: a point for every row, with the integers, all attributes, coordinate reference
/// system and records of the cloud, and with the columns that have a dimension. A dimension of the cloud with
/// one of their names is left out, with a warning. Attributes are fetched in parallel. `cloud` must outlive
/// the output. Errors: LasWriter's.
std::unique_ptr<AnswerOutput> answers_as_las(const std::filesystem::path& file, bool overwrite,
                                             const IndexedCloud& cloud, std::vector<AnswerColumn> columns,
                                             Listener& listener);

}  // namespace alidade::jobs
