// SPDX-License-Identifier: MIT
#include "extensions/parquet/write_parquet.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/output_file.h"
#include "base/parallel.h"
#include "base/words.h"
#include "extensions/parquet/column_chunk.h"
#include "extensions/parquet/file_column.h"
#include "extensions/parquet/thrift_writer.h"

namespace alidade::database {
namespace {

using Kind = ThriftWriter::Kind;

/// The beginning and the end of a file.
constexpr std::string_view k_magic = "PAR1";
constexpr std::size_t k_most_group_bytes = std::size_t{32} << 20;

/// Some rows, and their encoded columns.
struct RowGroup {
  std::size_t row_count = 0;
  Bounds bounds{};
  std::vector<ColumnChunk> chunks{};
};

/// Memory per row while it is encoded.
std::size_t row_bytes(const ChunkEncoding& encoding, std::size_t column_count) {
  return std::accumulate(encoding.blobs.begin(), encoding.blobs.end(),
                         sizeof(LatticePosition) + sizeof(std::uint64_t) + column_count,
                         [](std::size_t size, const ValueBlob& blob) { return size + blob.size; });
}

class ParquetFile {
 public:
  ParquetFile(const std::filesystem::path& path, OrderedCloud& cloud, const ParquetOptions& options)
      : file_(path, options.overwrite),
        cloud_(cloud),
        options_(options),
        encoding_(cloud.encoding(options.group_points)),
        columns_(file_columns(cloud.columns(), options.geometry)) {
    file_.write(std::as_bytes(std::span(k_magic)));
  }

  void write() {
    write_groups();
    write_footer();
    report(options_.progress, row_count_, cloud_.points.size());
    file_.commit();
  }

 private:
  void write_groups() {
    const std::size_t row_size = row_bytes(encoding_, columns_.size());
    const std::size_t rows = std::clamp<std::size_t>(k_most_group_bytes / row_size, 1, options_.group_points);
    std::vector<RowGroup> groups(std::clamp<std::size_t>(2 * k_most_group_bytes / (rows * row_size), 1,
                                                         std::min<std::size_t>(thread_count() + 1, 16)));
    cloud_.points.for_each_group(
        rows, groups.size(),
        [&](std::size_t slot, PickedPoints picked) { encode_group(std::move(picked), groups[slot]); },
        [&](std::size_t slot) {
          write_group(groups[slot]);
          report(options_.progress, row_count_, cloud_.points.size());
        });
  }

  void encode_group(PickedPoints picked, RowGroup& group) const {
    const EncodedChunks rows = encode(encoding_, std::exchange(picked, {}));
    group.row_count = rows.positions.size();
    group.bounds = rows.boxes.front();
    group.chunks.clear();
    for (const FileColumn& column : columns_)
      group.chunks.push_back(encode_column(column, rows, encoding_.lattice));
  }

  void write_group(const RowGroup& group) {
    std::uint64_t raw_size = 0;
    const std::uint64_t begin = file_.size();
    groups_.structure([&] {
      groups_.list(1, Kind::structure, group.chunks.size());
      for (std::size_t i = 0; i < group.chunks.size(); ++i) {
        write_chunk(columns_[i], group.chunks[i], group.row_count);
        raw_size += group.chunks[i].uncompressed_size;
      }
      groups_.int64(2, static_cast<std::int64_t>(raw_size));
      groups_.int64(3, static_cast<std::int64_t>(group.row_count));
      groups_.int64(5, static_cast<std::int64_t>(begin));
      groups_.int64(6, static_cast<std::int64_t>(file_.size() - begin));
    });
    ++group_count_;
    row_count_ += group.row_count;
    bounds_.grow(group.bounds);
  }

  void write_chunk(const FileColumn& column, const ColumnChunk& chunk, std::size_t row_count) {
    constexpr std::int32_t k_uncompressed = 0, k_zstd = 6;
    const std::uint64_t begin = file_.size();
    file_.write(chunk.pages);
    std::vector<PageEncoding> encodings = {chunk.encoding};
    if (chunk.dictionary_size > 0) encodings.push_back(PageEncoding::plain);
    if (column.may_be_null) encodings.push_back(PageEncoding::runs);
    groups_.structure([&] {
      groups_.int64(2, 0);  // the metadata is in the footer alone
      groups_.structure(3, [&] {
        groups_.int32(1, static_cast<std::int32_t>(column.type));
        groups_.list(2, Kind::int32, encodings.size());
        for (const PageEncoding encoding : encodings) groups_.element(static_cast<std::int32_t>(encoding));
        groups_.list(3, Kind::binary, 1);
        groups_.element(column.name);
        groups_.int32(4, chunk.is_compressed ? k_zstd : k_uncompressed);
        groups_.int64(5, static_cast<std::int64_t>(row_count));
        groups_.int64(6, static_cast<std::int64_t>(chunk.uncompressed_size));
        groups_.int64(7, static_cast<std::int64_t>(chunk.pages.size()));
        groups_.int64(9, static_cast<std::int64_t>(begin + chunk.dictionary_size));
        if (chunk.dictionary_size > 0) groups_.int64(11, static_cast<std::int64_t>(begin));
        groups_.structure(12, [&] {
          groups_.int64(3, static_cast<std::int64_t>(chunk.null_count));
          if (!chunk.range) return;
          groups_.binary(5, chunk.range->back());
          groups_.binary(6, chunk.range->front());
        });
      });
    });
  }

  void write_schema(ThriftWriter& footer) const {
    footer.list(2, Kind::structure, columns_.size() + 1);
    footer.structure([&] {
      footer.text(4, "schema");
      footer.int32(5, static_cast<std::int32_t>(columns_.size()));
    });
    for (const FileColumn& column : columns_) write_schema_element(column, footer);
  }

  /// The metadata of GeoParquet 1.1. `projjson`: empty if the reference system is unknown.
  std::string geo_metadata(const std::string& projjson) const {
    std::string box;
    if (!bounds_.empty()) {
      box = fmt::format(R"(,"bbox":[{},{},{},{},{},{}])", bounds_.min.x, bounds_.min.y, bounds_.min.z,
                        bounds_.max.x, bounds_.max.y, bounds_.max.z);
    }
    return fmt::format(R"({{"version":"1.1.0","primary_column":"{0}","columns":{{"{0}":{{"encoding":"WKB",)"
                       R"("geometry_types":["Point Z"],"crs":{1}{2}}}}}}})",
                       columns_.back().name, projjson.empty() ? "null" : projjson, box);
  }

  void write_metadata(ThriftWriter& footer) const {
    const Crs& crs = cloud_.whole.rest.crs;
    std::string projjson = crs.empty() || !options_.projjson ? "" : options_.projjson(crs);
    // Readers reject a footer with bytes that are not UTF-8.
    if (!is_utf8(projjson)) projjson.clear();
    std::vector<std::pair<std::string, std::string>> entries;
    const std::string& system = projjson.empty() ? crs.wkt : projjson;
    if (!system.empty() && is_utf8(system)) entries.emplace_back("crs", system);
    if (options_.geometry) entries.emplace_back("geo", geo_metadata(projjson));
    if (entries.empty()) return;
    footer.list(5, Kind::structure, entries.size());
    for (const auto& entry : entries) {
      footer.structure([&] {
        footer.text(1, entry.first);
        footer.text(2, entry.second);
      });
    }
  }

  void write_footer() {
    ThriftWriter footer;
    footer.structure([&] {
      footer.int32(1, 2);  // version of the format
      write_schema(footer);
      footer.int64(3, static_cast<std::int64_t>(row_count_));
      footer.list(4, Kind::structure, group_count_);
      footer.elements(groups_.bytes());
      write_metadata(footer);
      footer.text(6, "alidade version " ALIDADE_VERSION);
      footer.list(7, Kind::structure, columns_.size());
      for (std::size_t i = 0; i < columns_.size(); ++i)
        footer.structure([&] { footer.structure(1, [] {}); });  // statistics are ordered by type
    });
    constexpr std::size_t k_most = std::numeric_limits<std::int32_t>::max();
    check_that(footer.bytes().size() <= k_most, "too many row groups and columns for one Parquet file",
               fmt::format("at most {} bytes of metadata", k_most), std::to_string(footer.bytes().size()));
    file_.write(footer.bytes());
    const auto size = static_cast<std::uint32_t>(footer.bytes().size());
    file_.write(std::as_bytes(std::span(&size, 1)));
    file_.write(std::as_bytes(std::span(k_magic)));
  }

  OutputFile file_;
  OrderedCloud& cloud_;
  const ParquetOptions& options_;
  ChunkEncoding encoding_;
  std::vector<FileColumn> columns_;
  ThriftWriter groups_;  ///< the metadata of those written so far
  std::size_t group_count_ = 0;
  std::uint64_t row_count_ = 0;
  Bounds bounds_;
};

}  // namespace

void write_parquet(const std::filesystem::path& file, OrderedCloud& cloud, const ParquetOptions& options) {
  constexpr std::uint32_t k_least = 1024, k_most = 1 << 20;
  check_that(options.group_points >= k_least && options.group_points <= k_most,
             "invalid number of points per row group", fmt::format("{} to {}", k_least, k_most),
             std::to_string(options.group_points));
  ParquetFile(file, cloud, options).write();
}

}  // namespace alidade::database
