// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/json_form.h"
#include "renderer/scene.h"

// Every setting of a scene file, described once: its key, the member that it sets, what is allowed, and what
// it means. Reader, schema (scenes/schema/scene.schema.json), tables of docs/scene_format.md and fingerprints
// of images follow from it. Defaults are those of the structs.

namespace alidade::renderer {

/// Radiance and irradiance per channel.
inline constexpr NumberRange k_light{0.0, 1e9};
/// Degrees.
inline constexpr NumberRange k_angle{-360, 360};

/// A whole scene file. write() leaves out what no such file has; it writes names of files as they are in the
/// scene, which are relative to the working directory.
const JsonForm<Scene>& scene_form();

/// What a key of scene files means, such as "cloud/color/map": its description in the schema.
std::string meaning_of(const std::string& key);

const JsonForm<CloudSettings>& cloud_form();
const JsonForm<RenderSettings>& render_form();
const JsonForm<Sky>& sky_form();
/// Of points and triangles, which have colours of their own, so that the albedo may be left out.
const JsonForm<Material>& material_form();
/// Requires for writing: a Model is a mesh in a file.
const JsonForm<Object>& scene_object_form();

}  // namespace alidade::renderer
