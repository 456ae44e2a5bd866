// SPDX-License-Identifier: MIT
#include "cloud/las/write_las.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/interval.h"
#include "base/output_file.h"
#include "base/reorder_records.h"
#include "base/scratch_file.h"
#include "base/words.h"
#include "cloud/copc/plan_copc.h"
#include "cloud/las/las_records.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/record_writer.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

constexpr std::size_t k_written_block_bytes = 1 << 18;

std::int16_t scan_angle_steps(float degrees) {
  const double steps = std::nearbyint(degrees / k_las_scan_angle_step);
  if (std::isnan(steps)) return 0;
  return static_cast<std::int16_t>(std::clamp(steps, -32768.0, 32767.0));
}

std::uint8_t return_byte(ReturnNumbers returns) {
  return static_cast<std::uint8_t>(std::min<int>(returns.number, 15) | std::min<int>(returns.count, 15) << 4);
}

/// Writes value(column[row]) for the rows [first, first + count) of a column to the records at `at`.
template <class Column, class Value>
void put(const Column& column, std::size_t first, std::size_t count, std::byte* at, std::size_t record_size,
         Value value) {
  if (column.empty()) return;
  for (std::size_t row = first; row < first + count; ++row, at += record_size) store(at, value(column[row]));
}

constexpr auto k_as_it_is = [](const auto& value) { return value; };

}  // namespace

struct LasWriter::State {
  /// Points of COPC, which are sorted before they are written.
  struct Collected {
    ScratchSpace scratch;
    ScratchFile positions, records;
    Interval times{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    explicit Collected(const ScratchSpace& space)
        : scratch(space), positions(scratch.folder), records(scratch.folder) {}

    void add(const PointCloud& batch) {
      positions.append(std::as_bytes(std::span(batch.positions)));
      for (const double time : batch.gps_times) {
        if (!std::isfinite(time)) continue;
        times.low = std::min(times.low, time);
        times.high = std::max(times.high, time);
      }
    }
  };

  std::string name;
  OutputFile file;
  LasWriteOptions options;
  LasHeader header;
  std::vector<VariableLengthRecord> extended_records;
  bool has_normals = false;
  std::vector<ExtraDimension> extra_dimensions;  ///< as described in the file; the normals are the last
  LatticeExtent extent;
  std::vector<std::byte> block;
  std::vector<VariableLengthRecord> records;  ///< of the head, until it is written
  std::optional<LazLayout> packing;
  std::optional<RecordWriter> points;    ///< once the head is written
  std::optional<Collected> collected{};  ///< of COPC

  State(const std::filesystem::path& path, const LasWriteOptions& write_options)
      : name(path.string()), file(path, write_options.overwrite), options(write_options) {}

  /// Writes header and records, so that points can follow, in chunks of `counts` points if that is not empty.
  /// The record `first` comes before all others.
  void begin(const VariableLengthRecord* first = nullptr, std::vector<std::uint32_t> counts = {}) {
    if (packing) {
      if (first != nullptr) packing->chunk_size = 0;
      records.push_back(laszip_record(*packing));
    }
    if (first != nullptr) records.insert(records.begin(), *first);
    file.write(encode_las_header(header));
    for (VariableLengthRecord& record : records) {
      if (record.extended || record.data.size() > k_longest_las_record) {
        extended_records.push_back(std::move(record));
      } else {
        write_las_record(file, record, false);
        ++header.record_count;
      }
    }
    if (file.size() > std::numeric_limits<std::uint32_t>::max()) {
      throw Error({.file = name,
                   .problem = "the variable length records exceed the limit of LAS",
                   .expected = "less than 4 GiB",
                   .found = fmt::format("{} bytes", file.size())});
    }
    header.points_offset = static_cast<std::uint32_t>(file.size());
    points.emplace(file, packing, std::move(counts));
  }

  void write(const PointCloud& batch) {
    const std::size_t step = std::max<std::size_t>(k_written_block_bytes / header.point_size, 1);
    const std::uint64_t total = std::max(options.expected_points, header.point_count + batch.size());
    for (std::size_t first = 0; first < batch.size(); first += step) {
      const std::size_t count = std::min(step, batch.size() - first);
      encode(batch, first, count);
      count_points(batch, first, count);
      collected ? collected->records.append(block) : points->write(block);
      // Collecting the points of COPC is half of the work.
      report(options.progress, collected ? header.point_count / 2 : header.point_count, total);
    }
  }

  /// Writes the collected points in the order of the plan.
  CopcPlan write_collected() {
    const std::span<std::byte> bytes = collected->positions.map();
    CopcPlan plan =
        plan_copc(header.lattice, extent,
                  {reinterpret_cast<LatticePosition*>(bytes.data()), bytes.size() / sizeof(LatticePosition)},
                  collected->scratch);
    const VariableLengthRecord info = copc_info_record(plan.info, collected->times);
    begin(&info, plan.counts());
    std::uint64_t written = 0;
    reorder_records(collected->records, header.point_size, {plan.order.data(), plan.order.size()},
                    collected->scratch, [&](std::span<const std::byte> some) {
                      points->write(some);
                      written += some.size() / header.point_size;
                      report(options.progress, (header.point_count + written) / 2, header.point_count);
                    });
    return plan;
  }

  void encode(const PointCloud& batch, std::size_t first, std::size_t count) {
    const std::size_t size = header.point_size;
    block.assign(count * size, std::byte{0});
    const auto put_at = [&](int offset, const auto& column, auto value) {
      if (offset >= 0) put(column, first, count, block.data() + offset, size, value);
    };
    put_at(0, batch.positions, k_as_it_is);
    put_at(12, batch.intensities, k_as_it_is);
    put_at(14, batch.returns, return_byte);
    put_at(15, batch.flags, k_as_it_is);
    put_at(16, batch.classifications, k_as_it_is);
    put_at(17, batch.user_data, k_as_it_is);
    put_at(18, batch.scan_angles, scan_angle_steps);
    put_at(20, batch.point_source_ids, k_as_it_is);
    const LasPointLayout& layout = header.layout();
    put_at(layout.gps_time, batch.gps_times, k_as_it_is);
    put_at(layout.color, batch.colors, k_as_it_is);
    put_at(layout.near_infrared, batch.near_infrared, k_as_it_is);
    encode_extra_dimensions(batch, first, count);
  }

  void encode_extra_dimensions(const PointCloud& batch, std::size_t first, std::size_t count) {
    std::byte* at = block.data() + header.layout().size;
    const std::size_t own_count = extra_dimensions.size() - (has_normals ? 3 : 0);
    for (std::size_t i = 0; i < own_count; ++i) {
      const ExtraDimension& dimension = extra_dimensions[i];
      const std::size_t bytes = static_cast<std::size_t>(dimension.byte_count);
      const auto same = [&](const ExtraDimension& other) { return same_meaning(other, dimension); };
      // Among dimensions of one name, the one with the same index is the source.
      const auto& given = batch.extra_dimensions;
      const auto source = i < given.size() && same(given[i]) ? given.begin() + static_cast<std::ptrdiff_t>(i)
                                                             : std::find_if(given.begin(), given.end(), same);
      if (source != given.end() && !source->values.empty()) {
        assert(source->values.size() == batch.size() * bytes);
        for (std::size_t row = 0; row < count; ++row) {
          std::memcpy(at + row * header.point_size, source->values.data() + (first + row) * bytes, bytes);
        }
      }
      at += bytes;
    }
    if (has_normals) put(batch.normals, first, count, at, header.point_size, k_as_it_is);
  }

  void count_points(const PointCloud& batch, std::size_t first, std::size_t count) {
    header.point_count += count;
    for (std::size_t row = first; row < first + count; ++row) {
      extent.grow(batch.positions[row]);
      if (batch.returns.empty()) continue;
      const int number = std::min<int>(batch.returns[row].number, 15);
      if (number > 0) ++header.points_by_return[static_cast<std::size_t>(number - 1)];
    }
  }
};

LasWriter::LasWriter(const std::filesystem::path& path, const PointCloud& like, AttributeSet attributes,
                     const LasWriteOptions& options)
    : state_(std::make_unique<State>(path, options)) {
  attributes = attributes | like.attributes();
  LasHeader& header = state_->header;
  header.file_source_id = like.file_source_id;
  if (like.gps_time_is_standard) header.global_encoding |= k_las_gps_time_is_standard;
  if (!like.crs.wkt.empty()) header.global_encoding |= k_las_crs_is_wkt;
  header.project_id = like.project_id;
  header.system_identifier = "Alidade";
  header.generating_software = "Alidade " ALIDADE_VERSION;
  header.creation_day = options.creation_day;
  header.creation_year = options.creation_year;
  header.lattice = like.lattice;
  header.point_format = attributes.contains(Attribute::near_infrared) ? 8
                        : attributes.contains(Attribute::color)       ? 7
                                                                      : 6;
  state_->has_normals = attributes.contains(Attribute::normal);
  for (const ExtraDimension& dimension : like.extra_dimensions) {
    state_->extra_dimensions.push_back(description_of(dimension));
  }
  if (state_->has_normals) {
    for (const char* const name : {"NormalX", "NormalY", "NormalZ"})
      state_->extra_dimensions.push_back(plain_dimension(name, ScalarType::float32, "surface normal"));
  }
  std::size_t point_size = static_cast<std::size_t>(header.layout().size);
  for (const ExtraDimension& dimension : state_->extra_dimensions) {
    point_size += static_cast<std::size_t>(dimension.byte_count);
  }
  if (point_size > std::numeric_limits<std::uint16_t>::max()) {
    throw Error({.file = path.string(),
                 .problem = "the extra dimensions exceed the limit of LAS",
                 .expected = "at most 65535 bytes per point",
                 .found = std::to_string(point_size)});
  }
  header.point_size = static_cast<std::uint16_t>(point_size);

  std::vector<VariableLengthRecord> records = las_crs_records(like.crs);
  if (!state_->extra_dimensions.empty()) {
    std::vector<ExtraDimension> named = state_->extra_dimensions;
    const std::string changes = shorten_names(named);
    if (!changes.empty() && options.warn)
      options.warn(path.string() + ": LAS keeps 32 bytes of the names of extra dimensions: " + changes);
    records.push_back(las_extra_bytes_record(named, path.string()));
  }
  records.insert(records.end(), like.records.begin(), like.records.end());
  header.compressed = is_laz_name(path);
  if (header.compressed) {
    state_->packing = standard_laz_layout(header.point_format, header.point_size);
    check_laz_extra_bytes(*state_->packing, path.string());
  }
  state_->records = std::move(records);
  if (!is_copc_name(path)) {
    state_->begin();
  } else {
    // COPC records of input files describe octrees of other points.
    std::erase_if(state_->records,
                  [](const VariableLengthRecord& record) { return record.user_id == "copc"; });
    state_->collected.emplace(ScratchSpace{path.parent_path(), options.memory});
  }
}

LasWriter::~LasWriter() = default;

void LasWriter::write(const PointCloud& batch) {
  State& state = *state_;
  assert(batch.lattice == state.header.lattice);
  if (state.collected) state.collected->add(batch);
  state.write(batch);
}

void LasWriter::finish() {
  State& state = *state_;
  LasHeader& header = state.header;
  std::optional<CopcPlan> copc;
  if (state.collected) copc = state.write_collected();
  state.points->finish();
  if (header.point_count > 0) {
    header.bounds.grow(to_world(header.lattice, state.extent.low));
    header.bounds.grow(to_world(header.lattice, state.extent.high));
  }
  if (copc) {
    copc->info.root_page = state.file.size() + k_las_extended_record_head;
    state.extended_records.insert(state.extended_records.begin(),
                                  copc_hierarchy_record(*copc, state.points->chunks()));
  }
  if (!state.extended_records.empty()) header.extended_records_offset = state.file.size();
  header.extended_record_count = static_cast<std::uint32_t>(state.extended_records.size());
  for (const VariableLengthRecord& record : state.extended_records)
    write_las_record(state.file, record, true);
  state.file.write_at(0, encode_las_header(header));
  if (copc) {
    const VariableLengthRecord info = copc_info_record(copc->info, state.collected->times);
    state.file.write_at(k_las_header_size + k_las_record_head, std::as_bytes(std::span(info.data)));
  }
  state.file.commit();
}

bool is_copc_name(const std::filesystem::path& path) {
  return is_laz_name(path) && file_extension(path.stem()) == ".copc";
}

bool is_laz_name(const std::filesystem::path& path) {
  return file_extension(path) == ".laz";
}

void write_las(const std::filesystem::path& path, const PointCloud& cloud, const LasWriteOptions& options) {
  LasWriter writer(path, cloud, cloud.attributes(), options);
  writer.write(cloud);
  writer.finish();
}

}  // namespace alidade
