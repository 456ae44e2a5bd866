// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "renderer/scene.h"

// Parts of a scene as texts that are equal exactly if the parts are: numbers with 17 significant digits, no
// field left out. They are for comparing, not for reading back.

namespace alidade {

std::string text_of(const CloudSettings& cloud);
std::string text_of(const std::vector<Object>& objects);
std::string text_of(const Sky& sky);
std::string text_of(const std::optional<Sun>& sun);

}  // namespace alidade
