// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "cloud/cloud_inputs.h"
#include "cloud/input_view.h"
#include "geo/remote_file.h"
#include "tools/options.h"

namespace alidade::tools {

/// The points of the clouds that a command line selects, and their reference system.
struct ViewRequest {
  std::shared_ptr<InputView> view = std::make_shared<InputView>();
  std::string stated_system;  ///< --crs
  std::string wanted_system;  ///< --reproject; "auto": the zone
  std::string zone;           ///< UTM zone of the first cloud; empty until a cloud is opened for "auto"
  std::optional<CloudInput> first_cloud;  ///< of the first apply()
  std::once_flag is_zone_chosen;

  /// The clouds with this view, which is complete once the whole command line has been read.
  CloudInputs apply(CloudInputs clouds);
};

/// How the program opens remote files: set by ALIDADE_CACHE, then by the options of add_cache_options().
geo::RemoteOptions& remote_options();
/// Declares --cache, --cache-size and --allow-host.
void add_cache_options(const Fields& command);

/// Whether a command measures, so that heights must be in the unit of x and y, or shows clouds as they are.
enum class HeightUse { measured, as_stored };

/// Declares --classes, --ignore-classes, --where, --crop, --crop-crs, --columns, --crs, --reproject and
/// --vertical-unit, except those in `own`, which the command declares itself, then those of
/// add_cache_options().
std::shared_ptr<ViewRequest> add_view_options(const Fields& command,
                                              std::initializer_list<std::string_view> own = {},
                                              HeightUse height_use = HeightUse::measured);

}  // namespace alidade::tools
