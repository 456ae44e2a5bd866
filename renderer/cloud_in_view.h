// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cloud/copc/copc_file.h"
#include "renderer/render.h"

// A first look at clouds that take long to load, if their files are octrees themselves (COPC).

namespace alidade {

/// The files of a cloud, opened, if all are COPC and no more than 256; else none. Reads their hierarchies, no
/// points. Errors: as CopcFile's.
std::vector<std::unique_ptr<CopcFile>> open_copc_cloud(const CloudSettings& settings);

/// Loads what shows the cloud of these files best with about `most_points` of its points: nodes_in_view() of
/// `camera`, which may be null. Spheres grow with the gaps that this leaves, whatever radius the settings
/// have; all else is as load_cloud()'s. `progress` is in points. Errors: as load_cloud().
LoadedCloud load_coarse_cloud(const CloudSettings& settings,
                              const std::vector<std::unique_ptr<CopcFile>>& files, const Camera* camera,
                              std::uint64_t most_points, const Progress& progress = {});

}  // namespace alidade
