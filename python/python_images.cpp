// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include "camera/camera_json.h"
#include "compare/compared_image.h"
#include "compare/metrics/errors.h"
#include "compare/metrics/flip.h"
#include "compare/metrics/ssim.h"
#include "geo/raster.h"
#include "image/color_points.h"
#include "image/film.h"
#include "python/docstrings.h"
#include "python/python_cloud.h"
#include "renderer/overview.h"
#include "renderer/read_scene.h"
#include "renderer/render.h"
#include "visibility/observers.h"
#include "visibility/points/point_visibility.h"
#include "visibility/raster/ground.h"
#include "visibility/raster/viewshed.h"

namespace alidade::python {
namespace {

/// A dictionary as JSON; a text as it is.
std::string json_of(const py::object& given) {
  if (py::isinstance<py::str>(given)) return given.cast<std::string>();
  return py::module_::import("json").attr("dumps")(given).cast<std::string>();
}

camera::Camera camera_of(const py::object& given) {
  const std::string text = json_of(given);
  if (!text.starts_with("{")) return camera::read_camera(text);
  const JsonDocument document = parse_json(text, "camera");
  return camera::read_camera_node(JsonNode(document));
}

/// The scene with this cloud: the given parts, or a default one.
renderer::Scene scene_of(const py::object& given, const CloudData& data) {
  if (given.is_none()) return renderer::daylight_scene({data.name});
  py::dict parts = py::module_::import("json").attr("loads")(json_of(given));
  const py::dict cloud = parts.contains("cloud") ? py::dict(parts["cloud"]) : py::dict();
  cloud["file"] = data.name;
  if (cloud.contains("files")) cloud.attr("pop")("files");
  parts["cloud"] = cloud;
  if (!parts.contains("version")) parts["version"] = 1;
  renderer::Scene scene = renderer::parse_scene(json_of(parts), "scene");
  const bool has_mesh = std::ranges::any_of(scene.objects, [](const renderer::Object& object) {
    return std::holds_alternative<renderer::Model>(object);
  });
  if (has_mesh || scene.sun_by_time || std::holds_alternative<renderer::ImageSky>(scene.sky))
    throw input_error("the scene has meshes, a sun by date and time, or a sky from an image",
                      "a scene without them; 'alidade render' draws all of them");
  return scene;
}

renderer::LoadedCloud loaded(const Index& index, const renderer::CloudSettings& settings,
                             const Progress& progress) {
  const CloudData& data = *index.data();
  const AttributeColumns columns = data.points.columns();
  renderer::LoadedCloud cloud;
  cloud.octree = index.octree();
  const image::PointColoring coloring = image::choose_color(
      settings.color, {columns, columns.attributes(), data.size(), data.name}, cloud.warnings);
  renderer::color_cloud(cloud, coloring, columns, data.description(), data.name);
  renderer::choose_radius(settings, cloud, progress);
  return cloud;
}

std::vector<image::Layer> layers_of(const std::vector<std::string>& words) {
  std::vector<image::Layer> layers;
  for (const std::string& word : words) {
    const auto known = std::ranges::find(image::k_layers, word, &image::NamedLayer::name);
    if (known == image::k_layers.end()) {
      std::vector<std::string_view> names;
      for (const image::NamedLayer& each : image::k_layers) names.push_back(each.name);
      throw input_error("unknown layer", fmt::format("{}", fmt::join(names, ", ")), word);
    }
    layers.push_back(known->layer);
  }
  return layers;
}

/// One value, or three, of every pixel: (height, width) or (height, width, 3).
template <class Value, class Pixel>
py::array layer_array(const image::Film& film, const std::vector<Pixel>& pixels) {
  Shape shape{film.height, film.width};
  if (sizeof(Pixel) > sizeof(Value)) shape.push_back(sizeof(Pixel) / sizeof(Value));
  py::array_t<Value> array(shape);
  std::memcpy(array.mutable_data(), pixels.data(), sizeof(Pixel) * pixels.size());
  return array;
}

/// The image as PNG shows it: (height, width, 3) of 8 bits.
py::array image_of(const image::Film& film, const image::OutputSettings& output) {
  py::array_t<std::uint8_t> codes({py::ssize_t{film.height}, py::ssize_t{film.width}, py::ssize_t{3}});
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel)
    std::ranges::copy(image::displayed(film, pixel, output), codes.mutable_data() + 3 * pixel);
  return codes;
}

py::dict render(const Index& index, const py::object& camera, const py::object& scene_parts,
                std::array<int, 2> size, std::optional<int> samples,
                const std::vector<std::string>& layer_words, std::optional<double> exposure,
                std::optional<std::uint64_t> seed, int workers, const py::object& progress) {
  if (index.octree().size() == 0) throw input_error("the cloud has no points to render", "points");
  renderer::Scene scene = scene_of(scene_parts, *index.data());
  if (!camera.is_none()) scene.camera = camera_of(camera);
  const bool is_overview = !scene.camera;
  // The settings of a given scene hold, as in the program.
  const bool is_plain = is_overview && scene_parts.is_none();
  scene.render.samples = samples.value_or(is_plain ? renderer::k_overview_samples : scene.render.samples);
  check_that(scene.render.samples >= 1 && scene.render.samples <= renderer::k_max_samples,
             "samples out of range", fmt::format("1 to {}", renderer::k_max_samples),
             std::to_string(scene.render.samples));
  scene.render.seed = seed.value_or(scene.render.seed);
  if (is_plain && scene.render.mode != renderer::RenderMode::flat)
    scene.output.background = renderer::k_overview_background;
  renderer::check_shape(*scene.cloud);
  const std::vector<image::Layer> layers = layers_of(layer_words);
  const bool is_seen = std::ranges::count(layers, image::Layer::color) > 0;

  image::Film film;
  run_watched(workers, progress, [&](const Progress& watch) {
    const renderer::LoadedCloud cloud = loaded(index, *scene.cloud, watch);
    if (is_overview) {
      check_that(size[0] >= 1 && size[1] >= 1, "size out of range", "a width and height of 1 or more");
      scene.camera = renderer::overview_camera(cloud, size[0], size[1]);
      if (is_plain) renderer::light_from_scanners(scene, cloud, *scene.camera);
    }
    renderer::check_camera_position(*scene.camera, scene, cloud);
    const bool is_lit = scene.render.mode == renderer::RenderMode::path;
    if (is_seen)
      scene.output.exposure =
          exposure.value_or(is_plain && is_lit ? renderer::automatic_exposure(scene, &cloud, *scene.camera)
                                               : scene.output.exposure);
    film = renderer::render(scene, &cloud, {.progress = watch, .layers = layers});
  });

  if (!film.sees_anything() && PyErr_WarnEx(PyExc_UserWarning, "the camera sees nothing", 1) != 0)
    throw py::error_already_set();
  return arrays_of(film, scene.output);
}

/// Observers at eyes (m, 3), or on the ground (m, 2).
std::vector<visibility::GivenObserver> observers_of(const Doubles& array) {
  if (array.ndim() > 2)
    throw input_error("observers has the wrong shape", "(m, 3) or (m, 2)", "shape " + shape_text(array));
  const py::ssize_t width = array.shape(array.ndim() - 1);
  std::vector<visibility::GivenObserver> given;
  for (const double* row = array.data(); row < array.data() + array.size(); row += width) {
    visibility::GivenObserver& observer = given.emplace_back();
    observer.source = fmt::format("observer {}", given.size() - 1);
    observer.position = {row[0], row[1]};
    if (width == 3) observer.z = row[2];
  }
  return given;
}

/// Occluders, observers and the ground.
struct Sight {
  Sight(const Index& index, const std::vector<visibility::GivenObserver>& given, bool needs_ground,
        std::optional<double> height, std::optional<double> max_distance, int transparency,
        const Progress& progress)
      : occluders(index.octree(), {.transparency = transparency}, progress) {
    const bool is_on_ground =
        std::ranges::any_of(given, [](const visibility::GivenObserver& each) { return !each.z; });
    if (needs_ground || is_on_ground)
      ground =
          visibility::make_ground(occluders.octree(), index.data()->points.columns().classifications, {});
    visibility::ObserverDefaults defaults;
    defaults.height = height;
    if (max_distance) defaults.max_distance = *max_distance;
    observers = visibility::place_observers(given, defaults,
                                            [&](const glm::dvec2& position) { return ground->at(position); });
  }

  visibility::Occluders occluders;
  std::optional<visibility::Ground> ground;
  std::vector<visibility::Observer> observers;
};

py::array visible(const Index& index, const py::handle& observers, std::optional<double> height,
                  std::optional<double> max_distance, int transparency, int workers,
                  const py::object& progress) {
  const Doubles array = numbers_of(observers, "observers", {3, 2});
  const std::vector<visibility::GivenObserver> given = observers_of(array);
  const std::size_t points = index.octree().size();
  Shape shape = leading_shape(array);
  shape.push_back(static_cast<py::ssize_t>(points));
  py::array_t<bool> answers(shape);
  bool* const rows = answers.mutable_data();
  run_watched(workers, progress, [&](const Progress& watch) {
    const Sight sight(index, given, false, height, max_distance, transparency, watch);
    visibility::PointVisibilityOptions options;
    options.each_observer = [&](std::size_t observer, std::span<const std::uint8_t> seen) {
      std::ranges::copy(seen, rows + observer * points);
    };
    options.progress = watch;
    visibility::point_visibility(sight.occluders, sight.observers, options);
  });
  return answers;
}

visibility::ViewshedMode mode_of(const std::string& word) {
  if (word == "visible") return visibility::ViewshedMode::visible;
  if (word == "count") return visibility::ViewshedMode::count;
  if (word == "height") return visibility::ViewshedMode::height;
  if (word == "fraction") return visibility::ViewshedMode::fraction;
  throw input_error("unknown mode", "visible, count, height or fraction", word);
}

py::object viewshed(const Index& index, const py::handle& observers, double resolution,
                    const std::string& mode, const std::optional<std::array<double, 4>>& extent,
                    std::optional<double> height, double target_height, std::optional<double> max_distance,
                    int transparency, int workers, const py::object& progress) {
  const std::vector<visibility::GivenObserver> given =
      observers_of(numbers_of(observers, "observers", {3, 2}));
  visibility::ViewshedOptions options;
  options.mode = mode_of(mode);
  options.target_height = target_height;
  visibility::Viewshed map;
  run_watched(workers, progress, [&](const Progress& watch) {
    Bounds area = index.octree().bounds();
    if (extent) {
      area.min.x = (*extent)[0], area.min.y = (*extent)[1];
      area.max.x = (*extent)[2], area.max.y = (*extent)[3];
    }
    const Sight sight(index, given, true, height, max_distance, transparency, watch);
    options.progress = watch;
    map = visibility::viewshed(sight.occluders, *sight.ground, sight.observers,
                               geo::grid_over(area, resolution), options);
  });
  const geo::RasterGrid& grid = map.values.grid;
  py::array_t<float> values({py::ssize_t{grid.rows}, py::ssize_t{grid.columns}});
  std::ranges::copy(map.values.values, values.mutable_data());
  // In the order of affine.Affine, which rasterio uses.
  const py::tuple transform =
      py::make_tuple(grid.cell_size, 0.0, grid.north_west.x, 0.0, -grid.cell_size, grid.north_west.y);
  return answer_type("Raster")(values, transform, py::cast(&index).attr("crs"));
}

compare::ComparedImage compared(const py::handle& given, const char* name) {
  const py::array array = py::array::ensure(given);
  const bool fits = array && array.ndim() == 3 && array.shape(2) == 3;
  const std::string type = array ? py::str(array.dtype()).cast<std::string>() : "no array";
  const bool is_code = type == "uint8" || type == "uint16";
  if (!fits || array.size() == 0 || !(is_code || array.dtype().kind() == 'f')) {
    PyErr_Clear();
    throw input_error(fmt::format("{} is not an image", name),
                      "(height, width, 3) of uint8 or uint16 (sRGB), or floats (linear light)",
                      array ? fmt::format("{} of shape {}", type, shape_text(array)) : type);
  }
  compare::ComparedImage image;
  image.file = name;
  image.height = static_cast<int>(array.shape(0));
  image.width = static_cast<int>(array.shape(1));
  image.encoding = is_code ? compare::ColorEncoding::display : compare::ColorEncoding::linear;
  image.color_channels = 3;
  image.largest_code = type == "uint8" ? 255 : type == "uint16" ? 65535 : 0;
  const auto values = py::array_t<float, py::array::c_style | py::array::forcecast>(array);
  image.color.assign(values.data(), values.data() + values.size());
  const float largest = image.largest_code > 0 ? static_cast<float>(image.largest_code) : 1.0f;
  for (float& value : image.color) value /= largest;
  return image;
}

py::object compare_images(const py::handle& reference_array, const py::handle& test_array, int workers) {
  const compare::ComparedImage reference = compared(reference_array, "reference"),
                               test = compared(test_array, "test");
  if (reference.width != test.width || reference.height != test.height)
    throw input_error("the images differ in size",
                      fmt::format("{} x {} pixels", reference.width, reference.height),
                      fmt::format("{} x {}", test.width, test.height));
  compare::FlipResult flip;
  compare::ErrorMetrics errors;
  double ssim = 0.0, ms_ssim = 0.0;
  run_free(workers, [&] {
    flip = compare::flip(reference, test);
    errors = compare::error_metrics(reference, test, reference.encoding);
    const auto similarity = compare::similarity(reference, test);
    ssim = similarity.ssim;
    ms_ssim = similarity.ms_ssim;
  });
  py::array_t<float> map({py::ssize_t{reference.height}, py::ssize_t{reference.width}});
  std::ranges::copy(flip.map, map.mutable_data());
  return answer_type("Comparison")(flip.mean, ssim, ms_ssim, errors.psnr, errors.rmse, map);
}

}  // namespace

py::dict arrays_of(const image::Film& film, const image::OutputSettings& output) {
  py::dict arrays;
  if (film.holds(image::Layer::color)) {
    arrays["image"] = image_of(film, output);
    arrays["color"] = layer_array<float>(film, film.color);
    arrays["alpha"] = layer_array<float>(film, film.alpha);
  }
  const auto add = [&]<class Value>(image::Layer layer, const auto& pixels, Value) {
    const std::string name(image::k_layers[static_cast<std::size_t>(layer)].name);
    if (film.holds(layer)) arrays[py::str(name)] = layer_array<Value>(film, pixels);
  };
  add(image::Layer::depth, film.depth, float{});
  add(image::Layer::distance, film.distance, float{});
  add(image::Layer::normal, film.normal, float{});
  add(image::Layer::position, film.position, double{});
  add(image::Layer::albedo, film.albedo, float{});
  add(image::Layer::id, film.id, std::uint32_t{});
  add(image::Layer::variance, film.variance, float{});
  add(image::Layer::depth_sigma, film.depth_sigma, float{});
  add(image::Layer::coverage, film.coverage, float{});
  add(image::Layer::support, film.support, std::uint32_t{});
  return arrays;
}

void add_images(py::module_& module) {
  const py::arg_v workers = py::arg("workers") = -1, progress = py::arg("progress") = py::none();
  module.def("render", &render, k_render_doc, py::arg("index"), py::kw_only(), py::arg("camera") = py::none(),
             py::arg("scene") = py::none(), py::arg("size") = std::array{1200, 800},
             py::arg("samples") = py::none(), py::arg("layers") = std::vector<std::string>{"color"},
             py::arg("exposure") = py::none(), py::arg("seed") = py::none(), workers, progress);
  module.def("visible", &visible, k_visible_doc, py::arg("index"), py::arg("observers"), py::kw_only(),
             py::arg("height") = py::none(), py::arg("max_distance") = py::none(),
             py::arg("transparency") = 1, workers, progress);
  module.def("viewshed", &viewshed, k_viewshed_doc, py::arg("index"), py::arg("observers"),
             py::arg("resolution"), py::kw_only(), py::arg("mode") = "visible",
             py::arg("extent") = py::none(), py::arg("height") = py::none(), py::arg("target_height") = 0.0,
             py::arg("max_distance") = py::none(), py::arg("transparency") = 1, workers, progress);
  module.def("compare", &compare_images, k_compare_doc, py::arg("reference"), py::arg("test"), py::kw_only(),
             workers);
}

}  // namespace alidade::python
