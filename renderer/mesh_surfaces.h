// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/progress.h"
#include "mesh/triangle_tree.h"
#include "renderer/scene.h"

namespace alidade::renderer {

/// A mesh as part of a scene.
class MeshSurfaces final : public Surfaces {
 public:
  /// `name` for messages; a checksum is added. `progress` is in triangles. Requires: at least one triangle.
  /// Errors: Cancelled.
  MeshSurfaces(TriangleMesh mesh, std::string name, const Progress& progress = {});

  std::optional<Hit> closest(const Ray& ray) const override;
  Bounds bounds() const override { return tree_.bounds(); }
  std::string name() const override { return name_; }

  const TriangleTree& tree() const { return tree_; }

 private:
  std::string name_;  ///< made of the mesh before the tree takes it
  TriangleTree tree_;
};

}  // namespace alidade::renderer
