// SPDX-License-Identifier: MIT
#pragma once

#include "base/fingerprint.h"
#include "renderer/render.h"

namespace alidade {

/// All that the samples of a picture depend on, in a fixed order: what others follow from comes before them,
/// such as the cloud before a camera that looks at it. Numbers are written so that different ones have
/// different texts.
using PictureIdentity = Identity;

/// The identity of what render() would make of these. `cloud` may be null. Cost: a cloud read from an index
/// file is known by the checksums in it; any other is summed up as fast as memory delivers, about 16 bytes
/// per point.
PictureIdentity picture_identity(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options);

}  // namespace alidade
