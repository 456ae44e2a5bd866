// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cloud/copc/copc_file.h"
#include "renderer/scene.h"

namespace alidade {

/// Which nodes of COPC files to show if no more than `most_points` of their points are to be read: from the
/// roots down always the node whose points stand furthest apart in the picture (the spacing of its level,
/// divided by the distance from the camera to its cube). Nodes that would be too many are left out with those
/// below them, and so are nodes outside the cone around all that the camera sees. Without a camera, or with
/// one of parallel rays, it goes level by level. The roots of all files in view are always among them,
/// however many points they have. Files without nodes in view have none. Cost: in proportion to the nodes
/// that are looked at, times the logarithm of their number.
std::vector<ChosenNodes> nodes_in_view(std::span<const std::unique_ptr<CopcFile>> files, const Camera* camera,
                                       std::uint64_t most_points);

}  // namespace alidade
