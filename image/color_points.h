// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "cloud/damage.h"
#include "cloud/point_cloud.h"
#include "image/color_key.h"
#include "image/point_color.h"
#include "image/point_values.h"

namespace alidade::image {

/// Date and time of day of an adjusted standard GPS time (LAS 1.4: GPS seconds minus 10^9), whole seconds:
/// "2022-09-06 10:12:33". It is GPS time, ahead of UTC by the leap seconds since 1980 (18 s since 2017).
/// Empty outside the years 1 to 9999.
std::optional<std::string> gps_date(std::int64_t adjusted_seconds);

/// Day and time of a GPS week time: "Tuesday 10:12:33"; weeks begin on Sunday. Empty outside [0, 604800).
std::optional<std::string> gps_weekday(std::int64_t week_seconds);

// The attributes that points are coloured by, and whether a cloud has them.

/// The attributes a coloring needs; none for height and normal.
AttributeSet attributes_for(const PointColoring& coloring);

/// Lets an invalid coloring fail before points are read, as far as the heads of the files show it. `name` is
/// the cloud's in messages. Returns the attributes that were seen. Errors: none of the files has the
/// attribute; the message lists what they have. Those of open_cloud().
AttributeSet check_color_of_files(const PointColoring& coloring, const CloudInputs& inputs, Damage damage,
                                  const std::string& name);

/// A cloud that is about to be coloured.
struct ColorSource {
  const AttributeColumns& columns;  ///< those of attributes_for(), or more
  AttributeSet attributes;          ///< all that the cloud has, for messages
  std::uint64_t point_count = 0;
  std::string name;  ///< for messages
};

/// The coloring with `automatic` resolved: rgb if any point has a colour other than black, else
/// classification if it has several classes and at least half of the points one other than unclassified and
/// noise, else height; a choice other than rgb is added to `warnings`. A cloud without points is shown
/// by rgb then. Errors: the cloud lacks the attribute, and is not empty; a colour map or range for colours
/// that are no numbers, or class colours for what is no class.
PointColoring choose_color(const PointColoring& coloring, const ColorSource& cloud,
                           std::vector<std::string>& warnings);

/// Colours worked out from other values, and what they mean.
struct ColoredPoints {
  std::vector<Color16> colors;  ///< display-referred, by point id; empty for rgb and normal
  ColorKey key;
};

/// Colours the points of a cloud. `coloring` comes from choose_color(); `columns` has what it needs, in rows
/// by point id; `heights` are those of all points; `facts` holds reference system, files and the kind of GPS
/// time, and has no points. Points without a value get k_no_value_color. Rgb stays in the cloud, and the
/// colour of a normal is computed only where its surface is shaded: for both there are no colours, only the
/// key. Memory: 6 bytes per point. Cost: up to six passes over the values, in parallel; the result does not
/// depend on the number of threads.
ColoredPoints color_points(const PointColoring& coloring, const AttributeColumns& columns,
                           const PointCloud& facts, const PointValues& heights);

}  // namespace alidade::image
