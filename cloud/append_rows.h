// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "cloud/point_cloud.h"

namespace alidade {

/// Appends `count` points of zeros to the positions and to every column that is present or in `filled`. A
/// column of `filled` that is not there yet first gets zeros for the earlier points. Extra dimensions are
/// made by find_extra_dimension(); those that exist grow here. Never takes more memory than the new size
/// needs: growing by small blocks is cheap only in columns with room reserved.
void append_rows(PointCloud& cloud, AttributeSet filled, std::size_t count);

/// Index of the cloud's extra dimension that means the same as `like`, made with zeros for all points if
/// there is none. The values of `like` are not looked at. If a file has several of one meaning, `occurrence`
/// counts them from 0.
std::size_t find_extra_dimension(PointCloud& cloud, const ExtraDimension& like, std::size_t occurrence = 0);

/// Whether two extra dimensions can share a column: equal in name, type, scale, offset and "no value" mark.
bool same_meaning(const ExtraDimension& a, const ExtraDimension& b);

/// The dimension without its values.
ExtraDimension description_of(const ExtraDimension& dimension);

}  // namespace alidade
