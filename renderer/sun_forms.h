// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/scene_forms.h"

namespace alidade::renderer {

const JsonForm<geo::Sun>& sun_form();

/// "sun" of a scene, by its place in the sky or by time: Scene::sun or Scene::sun_by_time.
JsonKey<Scene> sun_key();

}  // namespace alidade::renderer
