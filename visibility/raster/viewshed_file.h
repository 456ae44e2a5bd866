// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "geo/raster_file.h"
#include "visibility/raster/map_image.h"
#include "visibility/raster/viewshed.h"

// Viewsheds in files: as rasters and as images.

namespace alidade::visibility {

/// Values of a map of ViewshedMode::visible, as those of gdal_viewshed (-vv, -iv, -ov).
struct SeenValues {
  std::uint8_t visible = 255, invisible = 0;
  std::optional<std::uint8_t> out_of_range = 0;  ///< empty: no data
};

/// The band of a map and the values that it shows.
struct ViewshedBand {
  std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<std::uint32_t>,
               std::vector<float>>
      values;
  double no_data = 0.0;
  std::string description, unit;

  geo::RasterBand band() const;
};

/// `visible` as bytes, `count` as 16-bit numbers (32-bit from 65535 observers on), the others as
/// float. The no-data value, for cells without ground and, unless SeenValues::out_of_range is set,
/// cells out of range: the largest number of the type (of bytes: the largest that has no other
/// meaning), -9999 of float. `options` are those of the viewshed; `observer_count` may be that of
/// objects; `length_unit` is that of the cloud.
ViewshedBand viewshed_band(const Viewshed& viewshed, const ViewshedOptions& options,
                           const SeenValues& seen_values, std::size_t observer_count,
                           const std::string& length_unit);

/// The image of a viewshed; seen cells are bright, hidden ones dark. `options` are those of the viewshed;
/// `observers` are marked, one for each object if there are objects.
MapImage viewshed_image(const Viewshed& viewshed, const ViewshedOptions& options,
                        std::span<const Observer> observers, const std::string& length_unit);

/// The seen share of a map; for ViewshedMode::height, at the target height.
struct SeenShare {
  double percent = 0.0;       ///< of the cells that an observer looks at
  std::uint64_t without = 0;  ///< cells without ground, or that no observer looks at
};
SeenShare seen_share(const Viewshed& viewshed, const ViewshedOptions& options);

}  // namespace alidade::visibility
