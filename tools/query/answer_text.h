// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/output_file.h"
#include "tools/query/answer_row.h"

namespace alidade {

enum class TextForm {
  csv,         ///< a header and a line per row; numbers with 17 significant digits, "inf" and "-inf"
  json_lines,  ///< an object per row; the same numbers, null for infinite ones
};

/// Answers as text, to stdout or into a file. Rows are worded in parallel.
class AnswerText final : public AnswerOutput {
 public:
  /// To stdout without a file. Errors: OutputFile's.
  AnswerText(std::vector<AnswerColumn> columns, TextForm form, std::unique_ptr<OutputFile> file);

  void write(const AnswerRows& rows) override;
  void finish() override;

 private:
  void put(const std::string& text);
  void put_header();

  std::vector<AnswerColumn> columns_;
  TextForm form_;
  std::string header_;  ///< until it is written: with the first rows, so that bad targets leave stdout empty
  std::unique_ptr<OutputFile> file_;
};

}  // namespace alidade
