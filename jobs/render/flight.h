// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "jobs/render/views.h"

namespace alidade::jobs {

/// A flight through the cloud, and the video that its images become.
struct FlightRequest {
  bool orbits = false;              ///< around the cloud
  std::filesystem::path keyframes;  ///< camera file; empty: none
  int frames = 150;
  double rate = 25.0;          ///< images per second
  std::filesystem::path file;  ///< the video, which take_video() fills in; empty: only images

  bool given() const { return orbits || !keyframes.empty(); }
};

/// Declares --orbit, --keyframes, --frames and --frame-rate.
void add_flight_fields(const Fields& fields, FlightRequest& request);

/// Removes a folder at the end of its life if it is empty: that of a video's images, if none was made.
struct EmptyFolder {
  std::filesystem::path folder;

  explicit EmptyFolder(std::filesystem::path path) : folder(std::move(path)) {}
  ~EmptyFolder() {
    std::error_code error;
    std::filesystem::remove(folder, error);
  }
  EmptyFolder(const EmptyFolder&) = delete;
  EmptyFolder& operator=(const EmptyFolder&) = delete;
};

/// Checks the request. If the output is a video (.mp4, .mkv, .mov, .webm), moves it to `request` and replaces
/// it by the pattern of its images, "yard_frames/%05d.png" for yard.mp4, whose folder is created. Errors: a
/// flight beside other cameras; a video without a flight; the file exists; odd width or height, which players
/// do not show.
void take_video(FlightRequest& request, const ViewsRequest& views, std::filesystem::path& output,
                bool overwrite);

/// The cameras of the images, through keyframes. Errors: fewer than two; an odd size of a video.
std::vector<camera::NamedCamera> flight_views(const FlightRequest& request,
                                              std::span<const camera::NamedCamera> keyframes);

/// The cameras of an orbit around the whole cloud. Errors: as seen_bounds().
std::vector<camera::NamedCamera> orbit_views(const FlightRequest& request, const ViewsRequest& views,
                                             const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                                             const std::filesystem::path& scene_file);

/// Makes the video, if one is requested, with the program ffmpeg, and removes its images. If ffmpeg is not
/// installed, the images stay, and a warning has the command that joins them. Returns whether there is a new
/// video. Errors: ffmpeg fails.
bool write_video(const FlightRequest& request, std::span<const std::filesystem::path> images,
                 const std::filesystem::path& pattern, bool overwrite, Listener& listener);

}  // namespace alidade::jobs
