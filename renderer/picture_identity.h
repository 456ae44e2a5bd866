// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "renderer/render.h"

namespace alidade {

/// One thing a picture depends on.
struct IdentityEntry {
  std::string name;   ///< as a message calls it: "seed", "sky"
  std::string value;  ///< exact: equal texts are equal things

  bool operator==(const IdentityEntry&) const = default;
};

/// All that the samples of a picture depend on, in a fixed order: what others follow from comes before them,
/// such as the cloud before a camera that looks at it. Numbers are written so that different ones have
/// different texts.
using PictureIdentity = std::vector<IdentityEntry>;

/// The identity of what render() would make of these. `cloud` may be null. Cost: a cloud read from an index
/// file is known by the checksums in it; any other is summed up as fast as memory delivers, about 16 bytes
/// per point.
PictureIdentity picture_identity(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options);

/// Errors: the first entry that differs, under `file`: "made with seed 1, asked for 2". Long texts are shown
/// from where they differ.
void check_identity(const PictureIdentity& made, const PictureIdentity& asked, const std::string& file);

}  // namespace alidade
