// SPDX-License-Identifier: MIT
#include "jobs/render/render.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/shown_text.h"
#include "geo/gdal_library.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "jobs/outputs.h"
#include "jobs/render/scene_parts.h"
#include "renderer/checkpoint.h"
#include "renderer/cloud_in_view.h"
#include "renderer/image_metadata.h"
#include "renderer/merge_parts.h"
#include "renderer/noise.h"

namespace alidade::jobs {
namespace {

/// An estimated error, or "unknown": one sample gives no estimate.
std::string error_text(double error, int digits) {
  return std::isinf(error) ? "unknown" : fmt::format("{:.{}g}", error, digits);
}

/// Metadata about the samples and noise reached.
std::vector<std::pair<std::string, std::string>> reached_metadata(
    const renderer::RenderStatistics& statistics) {
  std::vector<std::pair<std::string, std::string>> texts;
  texts.emplace_back("alidade:samples_reached",
                     fmt::format("{} {:.17g} {}", statistics.least_samples, statistics.mean_samples,
                                 statistics.most_samples));
  if (statistics.noise) {
    texts.emplace_back("alidade:noise_reached", fmt::format("{} {}", error_text(statistics.noise->median, 17),
                                                            error_text(statistics.noise->worst, 17)));
  }
  return texts;
}

/// The samples and noise reached, for people, and what stopped the render if it was not the requested limit.
std::string reached_text(const RenderRequest& request, const renderer::RenderStatistics& statistics) {
  std::string text = fmt::format("samples per pixel: {} to {}, mean {:.1f}", statistics.least_samples,
                                 statistics.most_samples, statistics.mean_samples);
  if (statistics.noise) {
    text += fmt::format("; estimated error of a tile: median {}, worst {}",
                        error_text(statistics.noise->median, 2), error_text(statistics.noise->worst, 2));
  }
  const bool is_noisy = statistics.noisy_tiles > 0, is_hurried = statistics.hurried_tiles > 0;
  if (is_noisy) {
    text += fmt::format("; target not reached in {} of {} tiles: raise {}", statistics.noisy_tiles,
                        statistics.tiles, is_hurried ? "--time-limit" : "--samples");
  }
  if (request.time_limit && !is_hurried) {
    const bool by_target = request.target_noise && !is_noisy;
    text += fmt::format("; stopped by {}, not by time", by_target ? "--target-noise" : "--samples");
  }
  return text;
}

/// Removes the checkpoint of a finished image, which is left if the process was killed before.
void remove_finished_checkpoint(const RenderPlan& plan) {
  const CheckpointRequest& checkpoint = plan.request().checkpoint;
  std::error_code error;
  if (!checkpoint.resume || !std::filesystem::exists(checkpoint.file, error)) return;
  const std::string image = renderer::read_checkpoint_summary(checkpoint.file).image;
  if (std::ranges::find(plan.finished, image, image_in_checkpoint) != plan.finished.end())
    std::filesystem::remove(checkpoint.file, error);
}

/// The file that shows the image under way. One that cannot be written is warned of once, and does not end
/// the run.
class PreviewFile {
 public:
  /// `output` and `metadata`: of the image.
  PreviewFile(const std::filesystem::path& file, const image::OutputSettings& output,
              renderer::ImageMetadata metadata, Listener& listener)
      : metadata_(std::move(metadata)), listener_(listener) {
    settings_.file = file;
    settings_.exposure = output.exposure;
    settings_.background = output.background;
    settings_.transparent = output.transparent && image::image_format(file) != image::ImageFormat::jpeg;
    const std::string text = "of an unfinished image, possibly reduced";
    metadata_.further.emplace_back(std::string(k_preview_mark), text);
    // JPEG stores no text but this one.
    metadata_.further.emplace_back("ImageDescription", fmt::format("{} {}", k_preview_mark, text));
  }

  void show(const image::Film& film) {
    try {
      renderer::write_image(film, settings_, metadata_, true);
    } catch (const Error& error) {
      if (!warned_) listener_.warn_always(std::string("no preview: ") + error.what());
      warned_ = true;
    }
  }

 private:
  image::OutputSettings settings_;
  renderer::ImageMetadata metadata_;
  Listener& listener_;
  bool warned_ = false;
};

constexpr std::uint64_t k_growth = 8;
// Two cores render this in half a second.
constexpr int k_longest_side = 640;
constexpr int k_samples = 8;
constexpr double k_seconds = 0.5;

/// The camera for an image no larger than a first look needs.
camera::Camera reduced(const camera::Camera& camera) {
  const double share = static_cast<double>(k_longest_side) / std::max(camera.width, camera.height);
  if (share >= 1.0) return camera;
  const auto side = [&](int pixels) { return std::max(1, static_cast<int>(pixels * share)); };
  return camera::resized(camera, side(camera.width), side(camera.height));
}

/// Renders a scene with a part of its cloud and shows the image.
void show_part(const RenderPlan& plan, renderer::Scene scene, const renderer::LoadedCloud& cloud,
               const Progress& progress, Listener& listener) {
  const RenderRequest& request = plan.request();
  scene.camera = reduced((plan.views.empty() ? view_of_cloud(request.views, scene, &cloud, request.scene_file)
                                             : plan.views[plan.images.front().view])
                             .camera);
  SilentListener silent(listener);
  complete_light(scene, &cloud, silent);
  scene.render.samples = std::min(scene.render.samples, k_samples);
  PreviewFile(request.preview, scene.output, {}, listener)
      .show(renderer::render(
          scene, &cloud,
          {.progress = progress, .layers = std::vector{image::Layer::color}, .time_limit = k_seconds}));
}

/// Shows an image in its preview file before its cloud is loaded, if the cloud consists of COPC files with
/// more than twice `preview_points` points: first with so many of them, then with eight times as many, and so
/// on up to half of them or 50 million. `scene` has its sky. Failures are no errors here: loading reports
/// them. Errors: Cancelled.
void show_first_looks(const RenderPlan& plan, const renderer::Scene& scene, Listener& listener) {
  const RenderRequest& request = plan.request();
  const Progress progress = [&listener](std::uint64_t, std::uint64_t) { return !listener.stops(); };
  const camera::Camera* const camera =
      plan.views.empty() ? nullptr : &plan.views[plan.images.front().view].camera;
  try {
    const std::vector<std::unique_ptr<CopcFile>> files = renderer::open_copc_cloud(request.files);
    std::uint64_t all = 0;
    for (const auto& file : files) all += file->header().point_count;
    for (std::uint64_t points = request.preview_points;
         points > 0 && points <= std::min(all / 2, k_most_preview_points); points *= k_growth) {
      const renderer::LoadedCloud cloud =
          renderer::load_coarse_cloud(*scene.cloud, request.files, files, camera, points, progress);
      if (cloud.octree.size() == 0) return;
      show_part(plan, scene, cloud, progress, listener);
      listener.note(fmt::format("{} shows {} of {} points", request.preview.string(),
                                short_count(static_cast<double>(cloud.octree.size())),
                                short_count(static_cast<double>(all))));
    }
  } catch (const Error& error) {
    listener.detail(std::string("no early preview: ") + error.what());
  }
}

/// A run of a plan.
class Rendering {
 public:
  Rendering(const RenderPlan& plan, Listener& listener)
      : plan_(plan),
        request_(plan.request()),
        listener_(listener),
        scene_(request_.scene),
        views_(plan.views) {}

  RenderResult result() {
    warn_all(listener_, plan_.warnings);
    if (plan_.is_empty()) {
      join_images(plan_.finished);
      remove_finished_checkpoint(plan_);
      listener_.note("all images exist");
      return std::move(result_);
    }
    prepare();
    load();
    write_maps();
    if (!plan_.images.empty() && request_.ground.with_color) write_images();
    if (scene_.cloud || !scene_.objects.empty()) {
      empty_.report(request_.views, cloud(), listener_);
      result_.empty_views = empty_.names();
    }
    result_.output = scene_.output;
    return std::move(result_);
  }

 private:
  const renderer::LoadedCloud* cloud() const { return cloud_ ? &*cloud_ : nullptr; }

  /// Does what can fail before the cloud is loaded.
  void prepare() {
    if (plan_.resumption && !plan_.is_resumed()) listener_.note(plan_.resumption->note);
    const std::uint32_t fewest = renderer::StopRule::k_fewest_samples;
    if (request_.target_noise && scene_.render.samples < static_cast<int>(fewest))
      listener_.warn(
          fmt::format("--target-noise tests tiles from {} samples on, but they get {}: raise --samples",
                      fewest, scene_.render.samples));
    // Before the work, so that a program that cannot write images does not render for hours first.
    image::load_library();
    if (std::ranges::any_of(plan_.images, is_map)) geo::load_gdal();
    listener_.detail(fmt::format("instruction set {}", name(best_instruction_set())));
    if (!plan_.images.empty()) load_sky(scene_, request_.scene_file, listener_);
    load_meshes(scene_, listener_);
    if (scene_.cloud && !request_.preview.empty() && !plan_.is_resumed() && !plan_.images.empty())
      show_first_looks(plan_, scene_, listener_);
  }

  static bool is_map(const PlannedImage& image) {
    return image::image_format(image.file) == image::ImageFormat::geotiff;
  }

  /// Loads the cloud, and chooses the views that depend on it.
  void load() {
    if (scene_.cloud) cloud_ = load_scene_cloud(plan_, listener_);
    if (cloud_) result_.crs = cloud_->crs;
    if (views_.empty()) {
      const std::uint64_t strays = !cloud_ || request_.views.from_above ? 0 : renderer::stray_count(*cloud_);
      if (strays > 0)
        listener_.note(fmt::format("the view leaves out {} points far from all others", strays));
      if (request_.flight.orbits)
        views_ = orbit_views(request_.flight, request_.views, scene_, cloud(), request_.scene_file);
      else
        views_ = {view_of_cloud(request_.views, scene_, cloud(), request_.scene_file)};
    }
    for (const PlannedImage& image : plan_.images)
      check_view(views_[image.view], image.file, scene_, cloud());
    for (const DepthMap& map : plan_.depth.maps) check_view(views_[map.view], {}, scene_, cloud());
  }

  /// Writes depth maps, and rasters of the ground.
  void write_maps() {
    const bool has_spheres = cloud_ && scene_.cloud->shape == renderer::PointShape::sphere;
    if (!plan_.depth.maps.empty() && has_spheres && !request_.has_given_shape)
      listener_.warn(
          fmt::format("spheres of radius {:.3g} m make depths too small, at grazing angles "
                      "by several radii; --surface disc, without --radius, avoids this",
                      cloud_->radius));
    write_depth_maps(
        plan_.depth, views_, scene_, cloud(),
        [this](const camera::NamedCamera& view) { return metadata_of(view); }, empty_, listener_);
    for (const DepthMap& map : plan_.depth.maps) keep({map.file, map.mask});
    if (plan_.depth.transforms) keep({plan_.depth.transforms->output});
    if (request_.ground.layers.empty() || !cloud_) return;
    write_ground_layers(request_.ground, scene_, *cloud_, request_.files, views_.front(), request_.overwrite,
                        empty_, listener_);
    for (const std::filesystem::path& file : request_.ground.files(scene_.output.file)) keep({file});
  }

  void keep(std::initializer_list<std::filesystem::path> files) {
    for (const std::filesystem::path& file : files)
      if (!file.empty()) result_.files.push_back(file);
  }

  /// The metadata of an image or depth map.
  renderer::ImageMetadata metadata_of(const camera::NamedCamera& view) const {
    renderer::ImageMetadata metadata;
    metadata.camera = view.camera;
    metadata.render = scene_.render;
    metadata.command = request_.command;
    if (!scene_.sun_origin.empty()) metadata.further.emplace_back("alidade:sun", scene_.sun_origin);
    if (!view.name.empty()) metadata.further.emplace_back("alidade:camera_name", view.name);
    for (const renderer::Object& object : scene_.objects)
      if (const auto* model = std::get_if<renderer::Model>(&object))
        metadata.further.emplace_back(model->mesh ? "alidade:mesh" : "alidade:site", model->name);
    if (!cloud_) return metadata;
    if (scene_.cloud->shape != renderer::PointShape::sphere)
      metadata.further.emplace_back("alidade:surface",
                                    scene_.cloud->shape == renderer::PointShape::disc ? "disc" : "blend");
    for (const CloudFile& file : cloud_->files) metadata.cloud_files.push_back(kept_name(file.path));
    metadata.cloud_offset = cloud_->octree.lattice().offset;
    metadata.crs = cloud_->crs;
    metadata.radius = cloud_->radius;
    if (cloud_->spacing_factor > 0.0) {
      metadata.further.emplace_back("alidade:radius_factor", fmt::format("{:.17g}", cloud_->spacing_factor));
      metadata.further.emplace_back("alidade:radius_neighbours",
                                    std::to_string(cloud_->octree.layers().spacing_neighbours));
    }
    for (const auto& text : image::color_metadata(cloud_->color)) metadata.further.push_back(text);
    return metadata;
  }

  /// Chooses light and exposure.
  void prepare_light() {
    if (request_.is_overview() && !request_.has_given_sun && cloud_ && views_.size() == 1)
      renderer::light_from_scanners(scene_, *cloud_, views_.front().camera);
    complete_light(scene_, cloud(), listener_);
    const bool is_automatic = request_.has_auto_exposure.value_or(request_.is_overview() && is_lit());
    if (!is_automatic || image::image_format(plan_.images.front().file) == image::ImageFormat::exr) return;
    // By the first image of a set, whether or not it exists already.
    scene_.output.exposure = renderer::automatic_exposure(scene_, cloud(), views_.front().camera);
    listener_.note(fmt::format("exposure {:+.2f} stops (--exposure)", scene_.output.exposure));
  }

  bool is_lit() const { return scene_.render.mode == renderer::RenderMode::path; }

  void write_images() {
    prepare_light();
    if (plan_.writes_legend) {
      image::write_legend(cloud_->color, request_.legend, request_.legend_size, request_.overwrite);
      keep({request_.legend});
    }
    try {
      render_images();
    } catch (const Cancelled&) {
      const std::filesystem::path& checkpoint = request_.checkpoint.file;
      if (!checkpoint.empty()) say_how_to_resume(listener_, checkpoint.string());
      throw;
    }
    say_result();
    std::vector<std::filesystem::path> images = plan_.finished;
    for (const PlannedImage& image : plan_.images) images.push_back(image.file);
    join_images(images);
  }

  /// Replaces the images of a flight by its video, if one is requested.
  void join_images(std::span<const std::filesystem::path> images) {
    if (!write_video(request_.flight, images, request_.output, request_.overwrite, listener_)) return;
    result_.files.resize(result_.files.size() - result_.images.size());
    for (RenderedImage& image : result_.images) image.file.clear();
    keep({request_.flight.file});
  }

  std::uint64_t camera_rays(const PlannedImage& image) const {
    const camera::Camera& camera = views_[image.view].camera;
    return renderer::pixel_count(camera.width, camera.height, request_.part.value_or(renderer::ImagePart())) *
           static_cast<std::uint32_t>(scene_.render.samples);
  }

  /// Renders and writes one image after the other, as one stage.
  void render_images() {
    std::uint64_t rest = 0, done = 0;
    for (const PlannedImage& image : plan_.images) rest += camera_rays(image);
    const std::size_t count = plan_.images.size();
    const std::unique_ptr<Listener::Stage> stage =
        listener_.begin(count == 1 ? "rendering" : fmt::format("rendering {} images", count), "camera rays");
    if (plan_.is_resumed()) stage->skip(*plan_.resumption->samples);
    const Progress progress = stage->callback();
    for (const PlannedImage& image : plan_.images) {
      rest -= camera_rays(image);
      std::uint64_t rays_of_image = 0;
      render_image(image, [&](std::uint64_t rays, std::uint64_t all_rays) {
        rays_of_image = rays;
        return progress(done + rays, done + all_rays + rest);
      });
      done += rays_of_image;
    }
    stage->finish();
  }

  void render_image(const PlannedImage& image, const Progress& progress) {
    scene_.camera = views_[image.view].camera;
    scene_.output.file = image.file;
    RenderedImage& rendered = result_.images.emplace_back(
        RenderedImage{.view = views_[image.view], .file = request_.written_file(image.file)});
    renderer::ImageMetadata metadata = metadata_of(rendered.view);
    renderer::RenderOptions options = options_of(image, metadata);
    options.progress = progress;
    if (request_.part) {
      renderer::render_part(
          scene_, cloud(), options,
          {rendered.file, request_.overwrite, renderer::image_entries(scene_.output, metadata)},
          &rendered.statistics);
    } else {
      image::Film film = renderer::render(scene_, cloud(), options, &rendered.statistics);
      if (has_limit())
        for (auto& text : reached_metadata(rendered.statistics)) metadata.further.push_back(std::move(text));
      if (!image.file.empty()) renderer::write_image(film, scene_.output, metadata, request_.overwrite);
      empty_.check(rendered.view, film.sees_anything());
      if (image.file.empty()) rendered.film = std::move(film);
    }
    keep({rendered.file});
    std::error_code error;
    if (!request_.checkpoint.file.empty()) std::filesystem::remove(request_.checkpoint.file, error);
    if (has_limit())
      listener_.note(fmt::format("{}: {}", shown_name(image), reached_text(request_, rendered.statistics)));
  }

  /// Whether more than --samples determines the samples.
  bool has_limit() const { return request_.time_limit || request_.target_noise; }

  renderer::RenderOptions options_of(const PlannedImage& image, const renderer::ImageMetadata& metadata) {
    const bool has_layers = image.file.empty() || image::image_format(image.file) == image::ImageFormat::exr;
    renderer::RenderOptions options{
        .layers = has_layers ? scene_.output.layers : std::vector{image::Layer::color},
        .time_limit = request_.time_limit,
        .target_noise = request_.target_noise,
        .part = request_.part.value_or(renderer::ImagePart())};
    if (!request_.preview.empty()) {
      const auto file = std::make_shared<PreviewFile>(request_.preview, scene_.output, metadata, listener_);
      options.preview = {.show = [file](const image::Film& film) { file->show(film); },
                         .interval = request_.preview_interval};
    }
    const CheckpointRequest& checkpoint = request_.checkpoint;
    if (checkpoint.file.empty()) return options;
    const bool is_resumed = plan_.is_resumed() && &image == &plan_.images.front();
    options.checkpoint = {.file = checkpoint.file,
                          .interval = checkpoint.interval,
                          .resume = is_resumed,
                          .image = image_in_checkpoint(image.file),
                          .failed = checkpoint_warning(listener_)};
    if (is_resumed) options.checkpoint->resumed = [this] { listener_.note(plan_.resumption->note); };
    return options;
  }

  void say_result() {
    double rays = 0.0, seconds = 0.0;
    for (const RenderedImage& image : result_.images) {
      rays += static_cast<double>(image.statistics.ray_count);
      seconds += image.statistics.seconds;
    }
    const std::string first = result_.images.front().file.string(),
                      last = result_.images.back().file.string();
    std::string written = first.empty() ? "" : "; wrote " + first;
    if (result_.images.size() > 1 && !first.empty()) written += " to " + last;
    if (request_.is_overview() && is_lit())
      written += fmt::format(" with {} samples per pixel (--samples)", scene_.render.samples);
    listener_.note(fmt::format("{} rays in {:.1f} s ({} rays/s){}", short_count(rays), seconds,
                               short_count(rays / seconds), written));
  }

  const RenderPlan& plan_;
  const RenderRequest& request_;
  Listener& listener_;
  renderer::Scene scene_;
  std::vector<camera::NamedCamera> views_;
  std::optional<renderer::LoadedCloud> cloud_;
  EmptyViews empty_;
  RenderResult result_;
};

}  // namespace

RenderResult run(const RenderPlan& plan, Listener& listener) {
  return Rendering(plan, listener).result();
}

}  // namespace alidade::jobs
