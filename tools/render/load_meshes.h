// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "renderer/scene.h"
#include "tools/console.h"

namespace alidade::tools {

/// Adds the files of a scene's meshes.
void add_mesh_files(const renderer::Scene& scene, std::vector<std::filesystem::path>& files);

/// Reads a scene's meshes, shows progress, and prints their sizes. Errors: as read_mesh().
void load_meshes(renderer::Scene& scene, Verbosity verbosity);

}  // namespace alidade::tools
