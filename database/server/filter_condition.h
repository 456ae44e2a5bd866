// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "database/point_filter.h"

namespace alidade {

/// A condition of SQL on x, y, z that holds wherever one of the filters does, and hardly anywhere else:
/// limits are widened by more than rounding, a billionth of them and of a unit and a trillionth of the
/// coordinates. It is made of comparisons that alidade_pg's indexes serve. "false" without filters.
std::string filter_condition(std::span<const PointFilter> any_of);

}  // namespace alidade
