// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

constexpr const char* k_colmap =
    "a COLMAP model, transforms.json, or a trajectory with quaternions (docs/cameras.md)";
constexpr const char* k_metashape =
    "its export as COLMAP (File > Export > Export Cameras, type Colmap), or transforms.json by "
    "'ns-process-data metashape'";

/// An export that is not supported, by words that its first bytes contain.
struct KnownExport {
  std::array<std::string_view, 3> marks;  ///< maybe empty
  const char* name;
  const char* remedy;
};

constexpr KnownExport k_exports[] = {
    {{"<document", "<chunk", "<sensor"}, "the XML of Agisoft Metashape", k_metashape},
    {{"xcr:", "", ""}, "the XMP of RealityCapture", k_colmap},
    {{"\"img_name\"", "\"rotation\"", "\"position\""},
     "the cameras.json of 3D Gaussian Splatting",
     "the COLMAP model that the splats were trained on, often in sparse/0"},
    {{"PinholeCamera", "\"extrinsic\"", ""},
     "the camera parameters of Open3D",
     "a camera file of Alidade or transforms.json"},
    {{"\"FeatureCollection\"", "\"translation\"", "\"rotation\""},
     "the shots.geojson of OpenDroneMap",
     "its opensfm/reconstruction.json"},
    {{"# Bundle file", "", ""}, "a bundle of Bundler", k_colmap},
    {{"NVM_V3", "", ""}, "a model of VisualSFM", k_colmap},
    {{"imageName", "Omega", "Kappa"}, "the external camera parameters of Pix4D", k_colmap},
    {{"PhotoID", "Omega", "Kappa"}, "the angles of Agisoft Metashape", k_metashape},
    {{"#name", "alt", "heading"},
     "the camera parameters of RealityCapture",
     "transforms.json by 'ns-process-data realitycapture', or a COLMAP model"},
    {{"yaw", "pitch", "roll"}, "a table of yaw, pitch and roll", k_colmap},
    {{"heading", "pitch", "roll"}, "a table of heading, pitch and roll", k_colmap},
};

}  // namespace

void reject_known_export(std::string_view start, const std::filesystem::path& file) {
  // Errors in a file of a format that is read are reported by its reader.
  for (const std::string_view own : {"qw", "look_at_x", "\"frames\"", "\"shots\"", "\"sfm_data_version\""})
    if (start.find(own) != start.npos) return;
  for (const KnownExport& known : k_exports) {
    const bool is_one = std::ranges::all_of(
        known.marks, [&](std::string_view mark) { return start.find(mark) != start.npos; });
    if (is_one) throw file_error(file, "cannot read " + std::string(known.name), known.remedy);
  }
}

}  // namespace alidade::camera
