// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "visibility/observers.h"
#include "visibility/occluders.h"

namespace alidade {

/// What is strange about observers, a sentence each, in their order: one that is farther outside the cloud
/// than the cloud is long, and than 100 metres; one that cannot reach it within its max_distance; one below
/// all points near it (within a square of half side 1, or the first of 2, 4, 8 and 16 that holds points): in
/// the ground, if it was not put on it; one inside the sphere of a point, which then does not block its view.
/// Cost: some microseconds each.
std::vector<std::string> observer_remarks(const Occluders& occluders, std::span<const Observer> observers);

}  // namespace alidade
