// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>

#include <string_view>

#include "octree/simd/instruction_set.h"
#include "renderer/camera.h"
#include "renderer/image.h"
#include "tools/command.h"
#include "tools/image_writer.h"
#include "tools/message.h"
#include "tools/render_options.h"

namespace alidade {
namespace {

/// Flags that cannot change the picture: --overwrite, and -q and -v alone or together.
bool is_silent_flag(std::string_view word) {
  if (word == "--overwrite" || word == "--quiet" || word == "--verbose") return true;
  return word.size() > 1 && word[0] == '-' && word.find_first_not_of("qv", 1) == std::string_view::npos;
}

std::string quoted(const std::string& word) {
  return word.find_first_of(" \t'\"") == std::string::npos ? word : fmt::format("\"{}\"", word);
}

/// The command line as metadata keep it: without the words that only say where the picture goes or how it is
/// computed, so that the same picture is the same file.
std::string picture_command(const CommandLine& words) {
  std::string text = "alidade";
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    const bool with_value = word.starts_with("--output=") || word.starts_with("--threads=") ||
                            (word.starts_with("-o") && word.size() > 2);
    if (is_silent_flag(word) || with_value) continue;
    if (word == "-o" || word == "--output" || word == "--threads") {
      ++i;
    } else {
      text += " " + quoted(word);
    }
  }
  return text;
}

std::vector<std::filesystem::path> input_files(const RenderCommand& command, const Scene& scene) {
  std::vector<std::filesystem::path> files;
  if (scene.cloud) files = scene.cloud->files;
  for (const std::filesystem::path& file : {command.scene_file, command.camera_file}) {
    if (!file.empty()) files.push_back(file);
  }
  return files;
}

LoadedCloud load(const CloudSettings& settings, Verbosity verbosity) {
  ProgressLine line("loading cloud", "B", verbosity);
  LoadedCloud cloud = load_cloud(settings, line.callback());
  line.finish();
  if (verbosity == Verbosity::quiet) return cloud;
  for (const std::string& warning : cloud.warnings) say_warning(warning);
  const char* const color = cloud.color == PointColor::rgb         ? "their rgb values"
                            : cloud.color == PointColor::intensity ? "intensity"
                                                                   : "height";
  say_note(fmt::format("{} points, coloured by {}, spheres of radius {:.4g}{}", cloud.octree.size(), color,
                       cloud.radius, settings.radius ? "" : " (from the spacing of the points)"));
  return cloud;
}

Camera choose_camera(const RenderCommand& command, const Scene& scene, const LoadedCloud* cloud) {
  if (cloud == nullptr) {
    throw Error({.file = command.scene_file.string(),
                 .problem = "the scene has neither a camera nor a cloud to look at"});
  }
  if (cloud->octree.size() == 0) {
    // What was asked for, which for an index file is not what its points came from.
    throw Error({.file = scene.cloud->files.front().string(),
                 .problem = "holds no points, so there is no view of it",
                 .expected = "a cloud with points, or --camera FILE"});
  }
  const ImageSize size = command.size.value_or(ImageSize{1200, 800});
  return overview_camera(visible_bounds(*cloud), size.width, size.height);
}

ImageMetadata metadata(const Scene& scene, const LoadedCloud* cloud, const CommandLine& words) {
  ImageMetadata metadata;
  metadata.camera = *scene.camera;
  metadata.render = scene.render;
  metadata.command = picture_command(words);
  if (cloud == nullptr) return metadata;
  for (const CloudFile& file : cloud->files) metadata.cloud_files.push_back(file.path.string());
  metadata.cloud_offset = cloud->octree.lattice().offset;
  metadata.crs_wkt = cloud->crs.wkt;
  metadata.radius = cloud->radius;
  return metadata;
}

ExitCode run(const RenderCommand& command, const CommandLine& words) {
  const Verbosity verbosity = command.verbosity.verbosity();
  Scene scene = requested_scene(command);
  check_image_name(scene.output.file);
  check_writable(scene.output.file, command.overwrite, input_files(command, scene));
  // Before the work, so that a program that cannot write pictures does not render for hours first.
  const ImageWriter write_picture = load_image_writer();
  if (verbosity == Verbosity::verbose) {
    say_note(fmt::format("instruction set {}", name(best_instruction_set())));
  }

  std::optional<LoadedCloud> loaded;
  if (scene.cloud) loaded = load(*scene.cloud, verbosity);
  const LoadedCloud* const cloud = loaded ? &*loaded : nullptr;
  if (!scene.camera) scene.camera = choose_camera(command, scene, cloud);

  ProgressLine line("rendering", "camera rays", verbosity);
  RenderStatistics statistics;
  const Film film = render(scene, cloud, {.progress = line.callback()}, &statistics);
  line.finish();
  write_picture(film, scene.output, metadata(scene, cloud, words), command.overwrite);
  if (verbosity != Verbosity::quiet) {
    say_note(fmt::format("{} rays in {:.1f} s ({} rays/s); wrote {}",
                         short_count(static_cast<double>(statistics.ray_count)), statistics.seconds,
                         short_count(static_cast<double>(statistics.ray_count) / statistics.seconds),
                         scene.output.file.string()));
  }
  return ExitCode::done;
}

}  // namespace

Command add_render(CLI::App& program, const CommandLine& command_line) {
  CLI::App* render = program.add_subcommand("render", "Path-trace a picture of a scene or of cloud files");
  const std::shared_ptr<RenderCommand> command = add_render_options(*render);
  render->footer(
      "Forms:\n"
      "  alidade render SCENE.json [-o FILE] [OPTIONS]\n"
      "  alidade render --cloud FILE... -o FILE [OPTIONS]\n"
      "\n"
      "With --cloud and no scene, the whole cloud is shown three-quarter from above, under a sun and a blue "
      "sky.\n"
      "Options stand above what the scene file says. Lengths are in metres (the unit of the cloud's CRS), "
      "angles in degrees.\n"
      "The bytes of the picture do not depend on the number of threads nor on the machine.\n"
      "Scene and camera files: docs/scene_format.md.\n"
      "\n"
      "Examples:\n"
      "  alidade render scenes/courtyard.json -o courtyard.png\n"
      "  alidade render --cloud site.las -o site.png\n"
      "  alidade render --cloud a.las b.las --size 1200x800 --samples 200 --radius 0.03 -o both.exr --layers "
      "color,depth,id\n");
  return {render, [command, command_line] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command, command_line); });
            return code;
          }};
}

}  // namespace alidade
