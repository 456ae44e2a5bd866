// SPDX-License-Identifier: MIT
#pragma once

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "renderer/render.h"

namespace alidade {

/// Makes points that have been read ready to be traced, but for their radii: chooses their colours, frees the
/// columns that these do not need, builds the octree. `cloud` holds attributes_for(settings.color);
/// `attributes` are all that its files have, for messages. Errors: as choose_color().
LoadedCloud index_cloud(PointCloud&& cloud, AttributeSet attributes, const CloudSettings& settings,
                        const Progress& progress = {});

}  // namespace alidade
