// SPDX-License-Identifier: MIT
#include "jobs/render/flight.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <algorithm>
#include <cerrno>
#include <iterator>
#include <string>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "camera/camera_path.h"

extern char** environ;

namespace alidade::jobs {
namespace {

bool is_video(const std::filesystem::path& file) {
  return has_extension(file, {".mp4", ".mkv", ".mov", ".webm"});
}

/// Runs a program and waits for it. Returns its exit code; empty if there is no such program.
std::optional<int> run_encoder(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t process = 0;
  const int error = ::posix_spawnp(&process, arguments[0], nullptr, nullptr, arguments.data(), environ);
  if (error == ENOENT) return std::nullopt;
  if (error != 0) throw system_error(words[0], "cannot start the program", error);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) throw system_error(words[0], "cannot wait for the program");
  }
  // If there is no such program, some systems detect that in the new process only.
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return code == 127 ? std::nullopt : std::optional(code);
}

void check_video_size(const std::filesystem::path& video, int width, int height) {
  if (width % 2 == 0 && height % 2 == 0) return;
  throw file_error(video, "the size of a video must be even", "an even --size such as 1280x720",
                   fmt::format("{}x{}", width, height));
}

/// The views of cameras, which are numbered.
std::vector<camera::NamedCamera> numbered(std::vector<camera::Camera> cameras) {
  std::vector<camera::NamedCamera> views;
  for (camera::Camera& each : cameras) views.push_back({fmt::format("{:05}", views.size()), std::move(each)});
  return views;
}

}  // namespace

void add_flight_fields(const Fields& fields, FlightRequest& request) {
  const Fields group = fields.group("Flights");
  const Field orbit = group.flag(
      "--orbit", "fly once around the whole cloud: images for -o yard_%04d.png, or a video for -o yard.mp4",
      request.orbits);
  group.excludes(orbit).file(
      "--keyframes", "FILE|FOLDER",
      "fly on a smooth way through these cameras, of the same files as --camera; a trajectory "
      "as CSV may have the columns x,y,z,look_at_x,look_at_y,look_at_z",
      request.keyframes);
  group.count("--frames", "N", "images of a flight, 2 to 100000 (default 150)", request.frames, 2, 100'000);
  group.number("--frame-rate", "N", "images per second of a video, 1 to 240 (default 25)", request.rate, 1.0,
               240.0);
}

void take_video(FlightRequest& request, const ViewsRequest& views, std::filesystem::path& output,
                bool overwrite) {
  if (request.given() && (!views.file.empty() || views.panorama || views.from_above))
    throw input_error("--orbit and --keyframes are cameras of their own",
                      "no --camera, --panorama and --orthographic beside them");
  if (!is_video(output)) return;
  if (!request.given()) throw file_error(output, "a video requires a flight", "--orbit, or --keyframes FILE");
  if (views.size) check_video_size(output, views.size->width, views.size->height);
  check_output(output, overwrite);
  request.file = output;
  const std::filesystem::path folder = output.parent_path() / (output.stem().string() + "_frames");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw system_error(folder.string(), "cannot make the folder of the images", error.value());
  output = folder / "%05d.png";
}

std::vector<camera::NamedCamera> flight_views(const FlightRequest& request,
                                              std::span<const camera::NamedCamera> keyframes) {
  if (keyframes.size() < 2)
    throw file_error(request.keyframes, "a flight requires two keyframes",
                     "more cameras, or --camera for images");
  std::vector<camera::Camera> cameras;
  for (const camera::NamedCamera& each : keyframes) {
    if (!request.file.empty()) check_video_size(request.file, each.camera.width, each.camera.height);
    cameras.push_back(each.camera);
  }
  return numbered(camera::cameras_between(cameras, request.frames));
}

std::vector<camera::NamedCamera> orbit_views(const FlightRequest& request, const ViewsRequest& views,
                                             const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                                             const std::filesystem::path& scene_file) {
  const ImageSize size = views.size.value_or(request.file.empty() ? k_overview_size : ImageSize{1280, 720});
  const Bounds seen = seen_bounds(scene, cloud, scene_file);
  std::vector<glm::dvec3> positions;
  if (cloud != nullptr) positions = renderer::visible_positions(*cloud);
  if (positions.empty()) std::ranges::copy(corners(seen), std::back_inserter(positions));
  return numbered(camera::orbit_cameras(positions, size.width, size.height, request.frames));
}

bool write_video(const FlightRequest& request, std::span<const std::filesystem::path> images,
                 const std::filesystem::path& pattern, bool overwrite, Listener& listener) {
  if (request.file.empty()) return false;
  // Beside the video, which appears under its name only when it is complete.
  const std::filesystem::path unfinished =
      pattern.parent_path() / ("video" + request.file.extension().string());
  std::vector<std::string> words = {
      "ffmpeg", "-loglevel",     "error", "-nostdin", "-y", "-framerate", fmt::format("{}", request.rate),
      "-i",     pattern.string()};
  if (!has_extension(request.file, {".webm"}))
    words.insert(words.end(), {"-c:v", "libx264", "-crf", "18", "-preset", "slow"});
  words.insert(words.end(), {"-pix_fmt", "yuv420p", unfinished.string()});
  const std::optional<int> code = run_encoder(words);
  if (!code) {
    words.back() = request.file.string();
    for (std::string& word : words) word = shell_word(word);
    listener.warn_always(fmt::format(
        "no video: the program ffmpeg is not installed; the {} images are {}, and this joins them: {}",
        images.size(), pattern.string(), fmt::join(words, " ")));
    return false;
  }
  if (*code != 0)
    throw file_error(request.file,
                     fmt::format("ffmpeg ended with code {}; the images are {}", *code, pattern.string()));
  check_output(request.file, overwrite);
  std::filesystem::rename(unfinished, request.file);
  for (const std::filesystem::path& image : images) std::filesystem::remove(image);
  std::error_code not_empty;
  std::filesystem::remove(pattern.parent_path(), not_empty);
  listener.note(fmt::format("wrote {}, {} images of {:.1f} s", request.file.string(), images.size(),
                            static_cast<double>(images.size()) / request.rate));
  return true;
}

}  // namespace alidade::jobs
