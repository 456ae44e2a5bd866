// SPDX-License-Identifier: MIT
// Points per second that one core decodes and encodes: of sample files, where they exist, and of records made
// here.
//   laz_bench --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "octree/cloud/las_point.h"
#include "octree/cloud/laz/layered_codec.h"
#include "octree/cloud/laz/pointwise_codec.h"
#include "tests/bench/laz_records.h"
#include "tests/cloud/laz/sample_chunks.h"

namespace alidade::bench {
namespace {

using Bytes = std::vector<std::byte>;

/// Both codecs under one name.
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

struct Encoder {
  explicit Encoder(const LazLayout& layout) {
    if (layout.compressor == LazCompressor::layered)
      layered = std::make_unique<LayeredEncoder>(layout);
    else
      pointwise = std::make_unique<PointwiseEncoder>(layout);
  }
  Bytes encode(std::span<const std::byte> records) {
    return layered != nullptr ? layered->encode(records) : pointwise->encode(records);
  }
  std::unique_ptr<LayeredEncoder> layered;
  std::unique_ptr<PointwiseEncoder> pointwise;
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
  Encoder encoder(input.layout);
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
  Encoder encoder(input.layout);
  for (auto _ : state) {
    for (const Chunk& chunk : input.chunks) benchmark::DoNotOptimize(encoder.encode(chunk.records).data());
  }
  set_rate(state, input);
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
  for (const int format : {1, 3, 7}) alidade::bench::register_input(alidade::bench::made_input(format));
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
