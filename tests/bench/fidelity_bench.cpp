// SPDX-License-Identifier: MIT
// fidelity_bench FOLDER: renders scans of the courtyard and the courtyard itself, prints their differences as
// tables in Markdown, and writes contact sheets into the folder.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <vector>

#include "image/image_file.h"
#include "simulation/scan.h"
#include "tests/support/fidelity.h"

namespace alidade {
namespace {

using renderer::CloudSettings;

/// A way to make surfaces of points.
struct Rule {
  const char* name;
  std::function<void(CloudSettings&)> apply;
  bool on_sheet = false;  ///< whether contact sheets show it
};

const std::vector<Rule>& rules() {
  static const std::vector<Rule> rules = {
      {"sphere, auto", [](CloudSettings&) {}, true},
      {"sphere, adapted", [](CloudSettings& cloud) { cloud.adapted_radius.emplace(); }},
      {"sphere, adapted 0.5", [](CloudSettings& cloud) { cloud.adapted_radius.emplace().factor = 0.5; }},
      {"disc", [](CloudSettings& cloud) { cloud.shape = renderer::PointShape::disc; }},
      {"blend", [](CloudSettings& cloud) { cloud.shape = renderer::PointShape::blend; }, true},
  };
  return rules;
}

renderer::LoadedCloud loaded(const test::ScanQuality& quality, const CloudSettings& settings) {
  PointCloud cloud = test::courtyard_cloud(quality);
  const AttributeSet attributes = simulation::scan_attributes();
  renderer::LoadedCloud result = renderer::index_cloud(std::move(cloud), attributes, settings, "scan");
  return result;
}

void print_head(const std::string& what) {
  fmt::print("\n### {}\n\n", what);
  fmt::print(
      "| points | surface | depth median / p95 cm | sigma cm | > 3 sigma % | interior p95 cm | > 10 cm off % "
      "| grown cm | holes % | "
      "normals ° | "
      "FLIP / SSIM / PSNR | s |\n|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
}

void print_row(const std::string& points, const char* rule, const test::Fidelity& f, double seconds) {
  fmt::print(
      "| {} | {} | {:.2f} / {:.0f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.2f} | {:.1f} | {:.3f} / "
      "{:.3f} / {:.1f} | "
      "{:.1f} |\n",
      points, rule, 100 * f.depth_median, 100 * f.depth_p95, 100 * f.sigma_median, 100 * f.surprises,
      100 * f.interior_p95, 100 * f.far_off, 100 * f.grown, 100 * f.holes, f.normal_median, f.flip, f.ssim,
      f.psnr, seconds);
  std::fflush(stdout);
}

class Bench {
 public:
  explicit Bench(const std::filesystem::path& folder) : folder_(folder) {}

  /// All rules for one scan, in one view.
  void rows(const std::string& sheet, const renderer::Scene& light, const test::FidelityView& view,
            const std::string& points, const test::ScanQuality& quality) {
    renderer::Scene scene = light;
    scene.camera = view.camera;
    const image::Film truth = test::exact_image(scene);
    std::vector<image::Film> shown = {truth};
    scene.cloud.emplace().normals = renderer::NormalMode::smooth;
    renderer::LoadedCloud cloud = loaded(quality, *scene.cloud);
    for (const Rule& rule : rules()) {
      scene.cloud.emplace().normals = renderer::NormalMode::smooth;
      rule.apply(*scene.cloud);
      renderer::choose_radius(*scene.cloud, cloud);
      double seconds = 0.0;
      const image::Film film = test::image_of(scene, cloud, &seconds);
      print_row(points, rule.name, test::fidelity(view.camera, truth, film, scene.output.exposure), seconds);
      if (rule.on_sheet) shown.push_back(film);
    }
    write_sheet(shown, scene.output.exposure, fmt::format("{}_{}.png", sheet, points));
  }

 private:
  /// Images of one size beside each other.
  void write_sheet(std::span<const image::Film> films, double exposure, const std::string& name) const {
    const image::Film& first = films.front();
    const std::vector<image::Layer> layers = {image::Layer::color};
    image::Film sheet(first.width * static_cast<int>(films.size()), first.height, layers);
    for (std::size_t i = 0; i < films.size(); ++i) {
      for (int y = 0; y < first.height; ++y) {
        for (int x = 0; x < first.width; ++x) {
          const std::size_t to = sheet.index(x + static_cast<int>(i) * first.width, y);
          sheet.color[to] = films[i].color[first.index(x, y)];
          sheet.alpha[to] = 1.0f;
        }
      }
    }
    image::write_image(sheet, {.file = folder_ / name, .exposure = exposure}, {}, true);
  }

  const std::filesystem::path folder_;
};

void run(const std::filesystem::path& folder) {
  constexpr int k_width = 600;
  Bench bench(folder);
  renderer::Scene flat = test::courtyard_light();
  flat.render.mode = renderer::RenderMode::flat;
  flat.render.samples = 4;
  flat.output.exposure = 0.0;
  const std::vector<std::pair<const char*, std::uint64_t>> densities = {
      {"1e5", 100'000}, {"1e6", 1'000'000}, {"5e6", 5'000'000}};
  const std::vector<test::FidelityView> views = test::fidelity_views(k_width);
  for (const test::FidelityView& view : views) {
    print_head(fmt::format("Flat colours, {}", view.name));
    for (const auto& [name, points] : densities) bench.rows(view.name, flat, view, name, {.points = points});
  }
  print_head("Flat colours, yard, 1 cm of noise");
  for (const auto& [name, points] : densities)
    bench.rows("noise", flat, views[0], name, {.points = points, .noise = 0.01});
  print_head("Flat colours, yard, one stray return in a thousand");
  for (const auto& [name, points] : densities)
    bench.rows("strays", flat, views[0], name, {.points = points, .stray_share = 0.001});
  renderer::Scene traced = test::courtyard_light();
  traced.render.samples = 16;
  print_head("Path-traced, yard, 16 samples");
  for (const auto& [name, points] : densities)
    bench.rows("traced", traced, views[0], name, {.points = points});
}

}  // namespace
}  // namespace alidade

int main(int count, char** arguments) {
  if (count != 2) {
    fmt::print(stderr, "usage: fidelity_bench FOLDER\n");
    return 2;
  }
  alidade::run(arguments[1]);
  return 0;
}
