// SPDX-License-Identifier: MIT
// What a million rays cost from NumPy, and the same rays in C++: in one process, on one index file that both
// map.
//   python_bench --benchmark_filter=/1000000/ --benchmark_repetitions=9
//       --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <pybind11/embed.h>
#include <pybind11/numpy.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "octree/index_file/index_file.h"
#include "octree/index_file/save_index.h"
#include "tests/bench/bench_site.h"
#include "tests/bench/timing.h"

namespace alidade::bench {
namespace {

namespace py = pybind11;
using namespace py::literals;

constexpr std::size_t k_rays = 1'000'000;

/// Rays as an array (n, 6), and as C++ prepares them.
struct RayPair {
  /// The set is repeated until there are k_rays. What lies before t_min is the surface that a ray leaves.
  RayPair(const std::vector<Ray>& set, double t_min) : array({k_rays, std::size_t{6}}) {
    double* row = array.mutable_data();
    rays.reserve(k_rays);
    for (std::size_t i = 0; i < k_rays; ++i, row += 6) {
      const Ray& ray = set[i % set.size()];
      for (int axis = 0; axis < 3; ++axis) {
        row[axis] = ray.origin[axis];
        row[3 + axis] = ray.direction[axis];
      }
      rays.push_back(make_ray(ray.origin, ray.direction, t_min));
    }
  }

  py::array_t<double> array;
  std::vector<Ray> rays;
  std::size_t hits = 0;
};

/// The campus as Python and as C++ open it.
class BothSites {
 public:
  explicit BothSites(std::size_t points) : site_(bench_site(points)) {
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / fmt::format("python_bench_{}.alidade", ::getpid());
    save_index(file, site_.octree, site_.cloud, {.overwrite = true});
    octree_ = open_index(file).octree();
    closest_ = py::module_::import("alidade").attr("open")(file.string()).attr("closest");
    std::filesystem::remove(file);  // the maps stay
  }

  /// Made and compared at the first call for a set.
  const RayPair& rays(const std::string& set) {
    const auto [found, is_new] = pairs_.try_emplace(set, site_.rays(set), site_.radius);
    if (is_new) count_hits(found->second);
    return found->second;
  }

  /// Hits with arrays of their own.
  py::object query_python(const RayPair& pair, int threads) const {
    return closest_(pair.array, "radius"_a = site_.radius, "t_min"_a = site_.radius, "workers"_a = threads);
  }
  void query_cpp(const RayPair& pair, int threads, std::vector<std::optional<Hit>>& hits) const {
    const RayQuery query{.radius = site_.radius, .measure = Measure::entry};
    on_threads(threads, [&] { closest(octree_, pair.rays, query, hits); });
  }

 private:
  /// Requires the same answers of both.
  void count_hits(RayPair& pair) const {
    std::vector<std::optional<Hit>> hits(k_rays);
    query_cpp(pair, 1, hits);
    const py::object columns = query_python(pair, 1);
    const auto ids = columns.attr("index").cast<py::array_t<std::int64_t>>();
    const auto entries = columns.attr("entry").cast<py::array_t<double>>();
    for (std::size_t i = 0; i < k_rays; ++i) {
      const std::int64_t expected = hits[i] ? static_cast<std::int64_t>(hits[i]->point_id) : -1;
      if (ids.at(i) != expected || (hits[i] && entries.at(i) != hits[i]->entry))
        throw std::runtime_error(fmt::format("ray {}: Python and C++ have different answers", i));
      pair.hits += hits[i].has_value();
    }
  }

  const BenchSite& site_;
  Octree octree_;
  py::object closest_;
  std::map<std::string, RayPair> pairs_;
};

/// By number of points.
using Sites = std::map<std::size_t, BothSites>;

void register_rays(Sites& sites, std::size_t points, const std::string& set, int threads) {
  const std::string count = std::to_string(points);
  const auto site = [&sites, points]() -> BothSites& {
    return sites.try_emplace(points, points).first->second;
  };
  add_benchmark(threads, {"python", "closest", set, with_threads("cpp", threads), count},
                [=](benchmark::State& state) {
                  const RayPair& pair = site().rays(set);
                  std::vector<std::optional<Hit>> hits(k_rays);
                  for (auto _ : state) site().query_cpp(pair, threads, hits);
                  report_rays(state, k_rays, pair.hits);
                });
  // The arrays of the answers are made and end within the time.
  add_benchmark(threads, {"python", "closest", set, with_threads("numpy", threads), count},
                [=](benchmark::State& state) {
                  const RayPair& pair = site().rays(set);
                  for (auto _ : state) site().query_python(pair, threads);
                  report_rays(state, k_rays, pair.hits);
                });
}

}  // namespace
}  // namespace alidade::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const pybind11::scoped_interpreter interpreter;
  pybind11::module_::import("sys").attr("path").attr("insert")(0, ALIDADE_MODULE_FOLDER);
  alidade::bench::Sites sites;  // ends before the interpreter
  for (const std::size_t points : {1'000'000, 10'000'000}) {
    for (const char* set : {"P", "S_shuffled"}) {
      for (const int threads : {1, 2}) alidade::bench::register_rays(sites, points, set, threads);
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
