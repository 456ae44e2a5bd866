// SPDX-License-Identifier: MIT
// Points per second that one core decodes and encodes: of sample files, where they exist, and of records made
// here; and those of whole files, read into clouds by one thread and two.
//   laz_bench --benchmark_repetitions=5
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "base/bytes.h"
#include "base/output_file.h"
#include "cloud/las/las_header.h"
#include "cloud/las/repack_las.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/read_cloud.h"
#include "tests/bench/laz_records.h"
#include "tests/cloud/las/las_builder.h"
#include "tests/cloud/laz/sample_chunks.h"

namespace alidade::bench {
namespace {

using Bytes = std::vector<std::byte>;

/// Both decoders under one name.
struct Decoder {
  explicit Decoder(const LazLayout& layout) {
    if (layout.compressor == LazCompressor::layered)
      layered = std::make_unique<LayeredDecoder>(layout);
    else
      pointwise = std::make_unique<PointwiseDecoder>(layout);
  }
  void decode(std::span<const std::byte> chunk, std::span<std::byte> records) {
    if (layered != nullptr) return layered->decode(chunk, records);
    pointwise->start(chunk);
    pointwise->decode(records);
  }
  std::unique_ptr<LayeredDecoder> layered;
  std::unique_ptr<PointwiseDecoder> pointwise;
};

struct Chunk {
  Bytes packed, records;
};

struct Input {
  std::string name;
  LazLayout layout;
  std::vector<Chunk> chunks;
  std::size_t point_count = 0;
};

Input file_input(const std::filesystem::path& path) {
  const test::SampleChunks sample = test::sample_chunks(path);
  Input input{.name = path.filename().string(), .layout = sample.layout, .chunks = {}};
  Decoder decoder(sample.layout);
  for (const test::SampleChunks::Chunk& chunk : sample.chunks) {
    Bytes records(chunk.point_count * sample.layout.record_size());
    decoder.decode(chunk.bytes, records);
    input.chunks.push_back({{chunk.bytes.begin(), chunk.bytes.end()}, std::move(records)});
    input.point_count += chunk.point_count;
  }
  return input;
}

Input made_input(int format) {
  const std::size_t size =
      static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size);
  Input input{.name = "made_format_" + std::to_string(format),
              .layout = standard_laz_layout(format, size),
              .chunks = {}};
  const std::size_t chunk_count = 4;
  input.point_count = chunk_count * k_laz_chunk_size;
  const Bytes records = scan_records(format, input.point_count);
  ChunkEncoder encoder(input.layout);
  for (std::size_t i = 0; i < chunk_count; ++i) {
    const auto some = std::span(records).subspan(i * k_laz_chunk_size * size, k_laz_chunk_size * size);
    input.chunks.push_back({encoder.encode(some), {some.begin(), some.end()}});
  }
  return input;
}

void set_rate(benchmark::State& state, const Input& input) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(input.point_count));
}

void decode(benchmark::State& state, const Input& input) {
  Decoder decoder(input.layout);
  Bytes records;
  for (const Chunk& chunk : input.chunks) records.resize(std::max(records.size(), chunk.records.size()));
  for (auto _ : state) {
    for (const Chunk& chunk : input.chunks)
      decoder.decode(chunk.packed, std::span(records).first(chunk.records.size()));
    benchmark::DoNotOptimize(records.data());
    benchmark::ClobberMemory();
  }
  set_rate(state, input);
}

void encode(benchmark::State& state, const Input& input) {
  ChunkEncoder encoder(input.layout);
  for (auto _ : state) {
    for (const Chunk& chunk : input.chunks) benchmark::DoNotOptimize(encoder.encode(chunk.records).data());
  }
  set_rate(state, input);
}

/// A LAZ file of records made here, under a name of its own until the program ends.
class MadeFile {
 public:
  static constexpr std::size_t k_points = 40 * k_laz_chunk_size;

  explicit MadeFile(int format)
      : path_(std::filesystem::temp_directory_path() /
              fmt::format("laz_bench_{}_{}.laz", ::getpid(), format)) {
    test::LasFile empty;
    empty.version_minor = format >= 6 ? 4 : 2;
    empty.point_format = format;
    Bytes las = test::build_las(empty);
    constexpr std::size_t k_count_offset = 107, k_long_count_offset = 247;
    if (format >= 6)
      store(las.data() + k_long_count_offset, std::uint64_t{k_points});
    else
      store(las.data() + k_count_offset, std::uint32_t{k_points});
    const Bytes records = scan_records(format, k_points);
    las.insert(las.end(), records.begin(), records.end());
    const std::filesystem::path plain = std::filesystem::path(path_).replace_extension(".las");
    OutputFile file(plain, true);
    file.write(las);
    file.commit();
    repack_las(plain, path_, {.overwrite = true});
    std::filesystem::remove(plain);
  }
  ~MadeFile() {
    std::error_code error;
    std::filesystem::remove(path_, error);
  }
  MadeFile(const MadeFile&) = delete;
  MadeFile& operator=(const MadeFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Reading with everything, as `alidade` does.
void register_reading(int format) {
  const auto file = std::make_shared<const MadeFile>(format);
  for (const int threads : {1, 2}) {
    benchmark::RegisterBenchmark(
        fmt::format("read/made_format_{}/threads:{}", format, threads).c_str(),
        [file, threads](benchmark::State& state) {
          tbb::task_arena arena(threads);
          for (auto _ : state) arena.execute([&] { benchmark::DoNotOptimize(read_cloud(file->path())); });
          state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(MadeFile::k_points));
        })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
}

void register_input(Input made) {
  const auto input = std::make_shared<const Input>(std::move(made));
  const std::string format = "/" + input->name;
  benchmark::RegisterBenchmark(("decode" + format).c_str(), [input](benchmark::State& state) {
    decode(state, *input);
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark(("encode" + format).c_str(), [input](benchmark::State& state) {
    encode(state, *input);
  })->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace alidade::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  for (const char* const name :
       {"lidar/lone-star.laz", "lidar_rgb/autzen_trim.laz",
        "lidar_rgb/Semis_2022_0906_6665_LA93_IGN69_ok.laz", "lidar_rgb/lion_takanawa.copc.laz"}) {
    const std::filesystem::path path = alidade::test::shared_data(name);
    if (!path.empty()) alidade::bench::register_input(alidade::bench::file_input(path));
  }
  for (const int format : {1, 2, 3, 6, 7}) alidade::bench::register_input(alidade::bench::made_input(format));
  for (const int format : {3, 7}) alidade::bench::register_reading(format);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
