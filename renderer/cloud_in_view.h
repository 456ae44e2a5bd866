// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cloud/copc/copc_file.h"
#include "octree/targets.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

namespace alidade::renderer {

/// Half-spaces that all have what a camera sees: nothing that lies outside one of them is in the image.
/// Tight for pinholes and parallel rays; a little wider for other lenses, whose borders are bent. None if the
/// camera sees a right angle or more to one side of its axis.
HalfSpaces view_planes(const camera::Camera& camera);

/// Which nodes of COPC files to show if no more than `most_points` of their points are to be read: from the
/// roots down always the node whose points are furthest apart in the image (the spacing of its level,
/// divided by the distance from the camera to its cube). Nodes that would be too many are left out with those
/// below them, and so are nodes outside the cone around all that the camera sees. Without a camera, or with
/// one of parallel rays, it goes level by level. The roots of all files in view are always among them,
/// however many points they have. Files without nodes in view have none. Cost: in proportion to the nodes
/// that are examined, times the logarithm of their number.
std::vector<ChosenNodes> nodes_in_view(std::span<const std::unique_ptr<CopcFile>> files,
                                       const camera::Camera* camera, std::uint64_t most_points);

// Previews of clouds that take long to load, if their files are octrees themselves (COPC).

/// The files of a cloud, opened, if all are COPC and no more than 256; else none. Reads their hierarchies, no
/// points. Errors: as CopcFile's.
std::vector<std::unique_ptr<CopcFile>> open_copc_cloud(const CloudInputs& inputs);

/// Loads what shows the cloud of these files best with about `most_points` of its points: nodes_in_view() of
/// `camera`, which may be null. Spheres grow with the gaps that this leaves, whatever radius the settings
/// have; all else is as load_cloud()'s. `progress` is in points. Errors: as load_cloud().
LoadedCloud load_coarse_cloud(const CloudSettings& settings, const CloudInputs& inputs,
                              const std::vector<std::unique_ptr<CopcFile>>& files,
                              const camera::Camera* camera, std::uint64_t most_points,
                              const Progress& progress = {});

}  // namespace alidade::renderer
