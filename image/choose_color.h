// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cloud/damage.h"
#include "cloud/point_cloud.h"
#include "image/point_color.h"

// Whether a cloud has what its points are to be coloured by.

namespace alidade {

/// The attributes this needs; none for height and normal.
AttributeSet attributes_for(const PointColoring& coloring);

/// Lets a wrong wish fail before points are read, as far as the beginnings of the files tell. `name` is the
/// cloud's in messages. Returns the attributes that were seen. Errors: none of the files has the attribute;
/// the message lists what they have. Those of open_cloud().
AttributeSet check_color_of_files(const PointColoring& coloring, std::span<const std::filesystem::path> files,
                                  Damage damage, const std::string& name);

/// A cloud that is about to be coloured.
struct ColorSource {
  const AttributeColumns& columns;  ///< those of attributes_for(), or more
  AttributeSet attributes;          ///< all that the cloud has, for messages
  std::uint64_t point_count = 0;
  std::string name;  ///< for messages
};

/// The coloring with `automatic` made out: rgb if any point has a colour other than black, else intensity if
/// it varies, else height; what was taken instead of rgb is added to `warnings`. A cloud without points is
/// shown by rgb then. Errors: the cloud lacks the attribute, and is not empty; a colour map or range for
/// colours that are no numbers, or class colours for what is no class.
PointColoring choose_color(const PointColoring& coloring, const ColorSource& cloud,
                           std::vector<std::string>& warnings);

}  // namespace alidade
