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

/// Which points of its clouds a command line selects, and in which reference system.
struct ViewRequest {
  std::shared_ptr<InputView> view = std::make_shared<InputView>();
  std::string stated;               ///< --crs
  std::string wanted;               ///< --reproject
  std::string zone;                 ///< the system of "auto", once a cloud has been opened
  std::optional<CloudInput> first;  ///< the cloud whose location decides the zone of "auto"
  std::once_flag is_zone_chosen;

  /// The clouds with this view, which is complete once the whole command line has been read.
  CloudInputs apply(CloudInputs clouds);
};

/// How the program opens remote files, by ALIDADE_CACHE and the options below.
geo::RemoteOptions& remote_options();
/// Declares --cache, --cache-size and --allow-host.
void add_cache_options(const Options& command);

/// Whether a command measures, for which heights must be in the unit of x and y, or shows clouds as they are.
enum class HeightUse { measured, as_stored };

/// Declares --classes, --ignore-classes, --where, --crop, --crop-crs, --columns, --crs, --reproject and
/// --vertical-unit, without those in `own`, which the command has itself, and those of add_cache_options().
std::shared_ptr<ViewRequest> add_view_options(const Options& command,
                                              std::initializer_list<std::string_view> own = {},
                                              HeightUse heights = HeightUse::measured);

}  // namespace alidade::tools
