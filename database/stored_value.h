// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "database/stored_column.h"

namespace alidade {

/// What SQL sees of a number in a blob: nothing (NULL) where it is the mark for no value; a whole number, the
/// second kind for those beyond the first; a real number, as all of a column with scale or offset are; bytes.
using ColumnValue =
    std::variant<std::monostate, std::int64_t, std::uint64_t, double, std::span<const std::byte>>;

/// The value whose number is at `at`, or which are column.size bytes there.
ColumnValue stored_value(const StoredColumn& column, const std::byte* at);

}  // namespace alidade
