// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "jobs/listener.h"
#include "jobs/query/query.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// The columns of the answers.
std::vector<AnswerColumn> answer_columns(const CheckedQuery& query);

/// Where answers go, in their order.
class AnswerOutput {
 public:
  virtual ~AnswerOutput() = default;
  /// Errors: no space, and other failures to write.
  virtual void write(std::span<const AnswerRow> rows) = 0;
  /// Ends the output; files appear under their name only here.
  virtual void finish() = 0;
};

/// Answers as text in the output, or, if it has no name, to what takes texts. Coordinates have the decimals
/// of the lattice, other numbers as many digits as give the same number again, unless the precision is given.
/// Formats rows in parallel. Errors: OutputFile's.
std::unique_ptr<AnswerOutput> open_text(const CheckedQuery& query, const Lattice& lattice);

/// Found points as LAS 1.4: a point for every row, with the integers, all attributes, coordinate reference
/// system and records of the cloud, and with the columns that have a dimension. A dimension of the cloud with
/// one of their names is left out, with a warning. Attributes are fetched in parallel. `cloud` must outlive
/// the output. Errors: LasWriter's.
std::unique_ptr<AnswerOutput> open_las(const CheckedQuery& query, const IndexedCloud& cloud,
                                       Listener& listener);

}  // namespace alidade::jobs
