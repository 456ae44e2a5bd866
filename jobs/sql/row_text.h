// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string_view>

#include "jobs/sql/statement.h"

namespace alidade::jobs {

/// Rows as text. Real numbers have as many digits as distinguish them from every other one, and always a dot
/// or an exponent.
enum class SqlForm {
  table,  ///< for people: columns aligned by the first 1000 rows, numbers with 15 digits and to the right;
          ///< NULL, blobs as x'00ff'
  csv,    ///< a header, then a row per line; NULL is an empty cell, a blob hexadecimal
  json    ///< an array of an object per row; NULL and what is not finite are null, a blob hexadecimal text
};

/// Hands rows on as text, some rows at a time.
RowSink row_text(SqlForm form, std::function<void(std::string_view)> write);

}  // namespace alidade::jobs
