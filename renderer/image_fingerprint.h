// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/fingerprint.h"
#include "renderer/render.h"

namespace alidade::renderer {

// Parts of a scene as texts that are equal exactly if the parts are; of files, names without folders. They
// are for comparing, not for reading back. Requires: numbers are finite.

std::string text_of(CloudSettings settings);
/// Requires surfaces for every Model.
std::string text_of(const std::vector<Object>& objects);
std::string text_of(Sky sky);
std::string text_of(const std::optional<geo::Sun>& sun);

/// The fingerprint of the image that render() would make: everything its samples depend on, in a fixed order
/// in which causes come first, such as the cloud before a camera that shows it. Different numbers have
/// different texts. `cloud` may be null. Cost: a cloud read from an index file is identified by the checksums
/// in it; of any other a checksum is computed, as fast as memory delivers about 16 bytes per point.
Fingerprint image_fingerprint(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options);

}  // namespace alidade::renderer
