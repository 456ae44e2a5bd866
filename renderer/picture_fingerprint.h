// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/fingerprint.h"
#include "renderer/render.h"
#include "renderer/scene.h"

// Parts of a scene as texts that are equal exactly if the parts are: numbers with 17 significant digits, no
// field left out. They are for comparing, not for reading back.

namespace alidade::renderer {

/// Of CloudSettings, std::vector<Object>, Sky or std::optional<geo::Sun>.
template <class Part>
std::string text_of(const Part& part);

/// All that the samples of a picture depend on, in a fixed order: what others follow from comes before them,
/// such as the cloud before a camera that looks at it. Numbers are written so that different ones have
/// different texts.
using PictureFingerprint = Fingerprint;

/// The fingerprint of what render() would make of these. `cloud` may be null. Cost: a cloud read from an index
/// file is known by the checksums in it; any other is summed up as fast as memory delivers, about 16 bytes
/// per point.
PictureFingerprint picture_fingerprint(const Scene& scene, const LoadedCloud* cloud,
                                       const RenderOptions& options);

}  // namespace alidade::renderer
