// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cloud/las/write_las.h"
#include "octree/index_file/indexed_cloud.h"
#include "tools/query/answer_row.h"

namespace alidade {

/// An extra dimension of found points: its name and the value of a row.
struct AnswerDimension {
  std::string name, description;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< written as uint64; or else
  double AnswerRow::*real = nullptr;          ///< written as float64
};

/// Found points as LAS 1.4: a point for every row, with the integers, all attributes, coordinate reference
/// system and records of the cloud, and with what the query found as extra dimensions. A dimension of the
/// cloud's own that has one of these names is left out. Attributes are fetched in parallel.
class AnswerLas final : public AnswerOutput {
 public:
  /// `cloud` must outlive this object. Errors: LasWriter's.
  AnswerLas(const std::filesystem::path& file, bool overwrite, const IndexedCloud& cloud,
            std::vector<AnswerDimension> dimensions);

  void write(const AnswerRows& rows) override;
  void finish() override;

  /// Names of the cloud's own dimensions that are left out.
  const std::vector<std::string>& replaced() const { return replaced_; }

 private:
  PointCloud points(std::span<const AnswerRow> rows) const;

  const IndexedCloud& cloud_;
  AttributeColumns columns_;  ///< without those that are left out
  std::vector<AnswerDimension> dimensions_;
  std::vector<std::string> replaced_;
  std::unique_ptr<LasWriter> writer_;
};

}  // namespace alidade
