// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "image/depth_map.h"
#include "jobs/render/views.h"
#include "renderer/image_metadata.h"

// Depth maps beside images, or instead of them: docs/depth.md.

namespace alidade::jobs {

struct DepthRequest {
  std::filesystem::path file;                ///< empty: none; for a set of cameras a pattern, like the mask's
  std::filesystem::path mask, transforms;    ///< empty: none
  std::optional<image::DepthFormat> format;  ///< empty: by the extension
  std::optional<double> scale;               ///< units per metre; empty: by the format
  image::Layer layer = image::Layer::depth;  ///< or distance
};

/// Declares the fields; they fill `request`.
void add_depth_fields(const Fields& fields, DepthRequest& request);

/// A depth map to make; a name is empty if the file exists and may stay, or is not requested.
struct DepthMap {
  std::size_t view = 0;  ///< index
  std::filesystem::path file, mask;
};

/// A transforms.json to be written again with its depth maps.
struct DepthTransforms {
  std::filesystem::path input, output;
  std::string text;  ///< of the input
};

/// All depth maps to make.
struct DepthPlan {
  image::DepthFormat format = image::DepthFormat::npy;
  double scale = 1.0;
  image::Layer layer = image::Layer::depth;
  bool overwrite = false;
  std::vector<DepthMap> maps;
  std::vector<std::filesystem::path> files;  ///< of all views
  std::optional<DepthTransforms> transforms;

  bool empty() const { return maps.empty() && !transforms; }
};

/// Whether existing files may be replaced, or stay.
struct ExistingFiles {
  bool overwrite = false, skip = false;
};

/// Lets a run fail before it starts. `views` are those of the images; empty if one view of the cloud is
/// chosen after loading. `inputs` are all files that are read, `outputs` all other files that are written.
/// Errors: an extension that is not the format's; names of a set as of image_names(); a file that would be
/// written twice, exists, or cannot be written; --transforms-out without a set of a transforms.json.
DepthPlan plan_depth_maps(const DepthRequest& request, const ViewsRequest& camera,
                          std::span<const camera::NamedCamera> views, ExistingFiles existing,
                          std::span<const std::filesystem::path> inputs,
                          std::span<const std::filesystem::path> outputs);

/// Writes the maps of these views one after the other, then the transforms.json; warns of depths that the
/// format cannot hold. `metadata` is that of the image of a view; `empty` gets the views whose maps hold no
/// depth. Errors: write failures; Cancelled.
void write_depth_maps(const DepthPlan& plan, std::span<const camera::NamedCamera> views,
                      const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                      const std::function<renderer::ImageMetadata(const camera::NamedCamera&)>& metadata,
                      EmptyViews& empty, Listener& listener);

}  // namespace alidade::jobs
