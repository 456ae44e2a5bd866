// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/checkpoint.h"
#include "visibility/lines/line_report.h"

namespace alidade {

/// A report as the bytes of a part (run_parts.h).
void put_report(const LineReport& report, PartWriter& writer);

/// Gives it back. Errors: those of PartReader; points that a cloud of so many does not have.
LineReport take_report(PartReader& reader, std::uint64_t point_count);

}  // namespace alidade
