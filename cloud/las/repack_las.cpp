// SPDX-License-Identifier: MIT
#include "cloud/las/repack_las.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

#include "base/bytes.h"
#include "base/error.h"
#include "base/output_file.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/las/write_las.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/laz_points.h"
#include "cloud/laz/record_writer.h"

namespace alidade {
namespace {

constexpr std::size_t k_repacked_bytes = 1 << 20;

// Byte offsets of header fields: LAS Specification 1.4 R15, table 3.
constexpr std::size_t k_points_field = 96, k_record_count_field = 100, k_point_format_field = 104;
constexpr std::size_t k_wave_packets_field = 227, k_extended_records_field = 235;
constexpr std::byte k_laz_format_mark{0x80}, k_laz_format_marks{0xc0};

/// A LAS or LAZ file, with everything that it contains about its points.
struct Source {
  InputFile file;
  std::vector<std::string> warnings;
  LasHeader header;
  LasRecords records;
  std::optional<LazLayout> packing;

  explicit Source(const std::filesystem::path& path)
      : file(path),
        header(read_las_header(file, warnings)),
        records(read_las_records(file, header, warnings)) {
    packing = read_packing(file, header, records);
    if (records.copc_info) {
      throw Error({.file = file.name(), .problem = "COPC cannot be repacked record by record"});
    }
  }

  /// Where the points end, packed or not.
  std::uint64_t points_end() {
    if (!packing) return header.points_end();
    const std::uint64_t extended =
        header.extended_record_count > 0 ? header.extended_records_offset : file.size();
    if (extended < header.points_offset + k_laz_table_offset_bytes) return extended;
    std::string missing;
    const auto chunks = packing->compressor == LazCompressor::pointwise
                            ? std::nullopt
                            : read_chunk_table(file, header, *packing, missing);
    // Without a table only the extended records have a known offset.
    if (!chunks) return extended;
    const std::uint64_t table = chunks->empty() ? header.points_offset + k_laz_table_offset_bytes
                                                : chunks->back().offset + chunks->back().byte_count;
    const auto table_offset =
        load<std::int64_t>(file.view(header.points_offset, k_laz_table_offset_bytes).data());
    // A writer that could not seek wrote the offset of the table behind the table.
    const std::uint64_t end =
        table + encode_chunk_table(*chunks, *packing).size() + (table_offset == -1 ? 8 : 0);
    return std::min(end, extended);
  }
};

/// Removes the records "laszip encoded" from header and records; returns the offset behind the last record.
std::size_t take_out_laszip(std::vector<std::byte>& head, const LasHeader& header) {
  std::uint32_t count = header.record_count;
  std::size_t offset = header.header_size;
  for (std::uint32_t i = 0; i < header.record_count; ++i) {
    const std::size_t size = k_las_record_head + load<std::uint16_t>(head.data() + offset + 20);
    const bool laszip = las_text(head.data() + offset + 2, 16) == k_laszip_user_id &&
                        load<std::uint16_t>(head.data() + offset + 18) == k_laszip_record_id;
    if (!laszip) {
      offset += size;
      continue;
    }
    const auto begin = head.begin() + static_cast<std::ptrdiff_t>(offset);
    head.erase(begin, begin + static_cast<std::ptrdiff_t>(size));
    --count;
  }
  store(head.data() + k_record_count_field, count);
  return offset;
}

/// Everything that is written before the points, except that the header's offsets of what follows the points
/// are those of the source: see move_offsets().
std::vector<std::byte> make_head(Source& source, const std::optional<LazLayout>& packing) {
  std::vector<std::byte> head(source.header.points_offset);
  source.file.read_at(0, head);
  const std::size_t records_end = take_out_laszip(head, source.header);
  head[k_point_format_field] &= ~k_laz_format_marks;
  if (packing) {
    const VariableLengthRecord record = laszip_record(*packing);
    std::vector<std::byte> bytes = las_record_head(record, false);
    std::ranges::copy(std::as_bytes(std::span(record.data)), std::back_inserter(bytes));
    head.insert(head.begin() + static_cast<std::ptrdiff_t>(records_end), bytes.begin(), bytes.end());
    store(head.data() + k_record_count_field, load<std::uint32_t>(head.data() + k_record_count_field) + 1);
    head[k_point_format_field] |= k_laz_format_mark;
  }
  if (head.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error({.file = source.file.name(),
                 .problem = "no space for another variable length record",
                 .expected = "less than 4 GiB",
                 .found = fmt::format("{} bytes", head.size())});
  }
  store(head.data() + k_points_field, static_cast<std::uint32_t>(head.size()));
  return head;
}

/// Sorts unpacked records, which arrive in any order between two calls of make_room(), by their rows.
class OrderedRecords final : public LazSink {
 public:
  OrderedRecords(RecordWriter& output, std::size_t record_size)
      : output_(output), record_size_(record_size) {}

  void make_room(std::uint64_t count) override {
    flush();
    records_.resize(static_cast<std::size_t>(count) * record_size_);
  }
  void take(const std::byte* records, std::size_t count, std::uint64_t first_row) override {
    const auto offset = static_cast<std::size_t>(first_row - first_row_) * record_size_;
    std::copy_n(records, count * record_size_, records_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void flush() {
    output_.write(records_);
    first_row_ += records_.size() / record_size_;
    records_.clear();
  }

 private:
  RecordWriter& output_;
  std::size_t record_size_;
  std::vector<std::byte> records_;
  std::uint64_t first_row_ = 0;
};

void copy_points(Source& source, RecordWriter& output, const Progress& progress) {
  if (source.packing) {
    OrderedRecords records(output, source.header.point_size);
    LazPoints points(source.file, source.header, *source.packing, Damage::reject);
    points.read(LazLayers{}, records, progress);
    records.flush();
    source.warnings.insert(source.warnings.end(), points.warnings().begin(), points.warnings().end());
    return;
  }
  const std::size_t size = source.header.point_size;
  const std::uint64_t end = source.header.points_end();
  const std::uint64_t step = std::max<std::uint64_t>(k_repacked_bytes / size, 1) * size;
  for (std::uint64_t offset = source.header.points_offset; offset < end; offset += step) {
    const auto count = static_cast<std::size_t>(std::min(step, end - offset));
    output.write(source.file.view(offset, count));
    report(progress, offset + count, source.file.size());
  }
}

/// Adapts the header's offsets of what follows the points, which moves from byte `from` to byte `to`.
void move_offsets(std::vector<std::byte>& head, const LasHeader& header, std::uint64_t from,
                  std::uint64_t to) {
  const auto move = [&](std::size_t field) {
    const auto offset = load<std::uint64_t>(head.data() + field);
    if (offset >= from) store(head.data() + field, offset - from + to);
  };
  if (header.version_minor >= 3 && header.header_size >= k_wave_packets_field + 8) move(k_wave_packets_field);
  if (header.extended_record_count > 0) move(k_extended_records_field);
}

}  // namespace

bool can_repack(const std::filesystem::path& input) {
  try {
    InputFile file(input);
    const std::span<const std::byte> start = file.view_up_to(0, k_las_header_size + 6);
    if (start.size() < 4 || las_text(start.data(), 4) != "LASF") return false;
    // In a COPC file, the first record behind the 1.4 header is its own.
    return start.size() < k_las_header_size + 6 ||
           las_text(start.data() + k_las_header_size + 2, 4) != "copc";
  } catch (const Error&) {
    return false;
  }
}

RepackedFile repack_las(const std::filesystem::path& input, const std::filesystem::path& output,
                        const RepackOptions& options) {
  Source source(input);
  std::optional<LazLayout> packing;
  if (is_laz_name(output)) {
    packing = standard_laz_layout(source.header.point_format, source.header.point_size);
    check_laz_extra_bytes(*packing, input.string());
  }
  OutputFile file(output, options.overwrite);
  std::vector<std::byte> head = make_head(source, packing);
  file.write(head);
  RecordWriter records(file, packing);
  copy_points(source, records, options.progress);
  records.finish();
  const std::uint64_t end = source.points_end();
  move_offsets(head, source.header, end, file.size());
  for (std::uint64_t offset = end; offset < source.file.size(); offset += k_repacked_bytes)
    file.write(source.file.view_up_to(offset, k_repacked_bytes));
  file.write_at(0, head);
  report(options.progress, source.file.size(), source.file.size());
  file.commit();
  return {.point_count = source.header.point_count, .warnings = std::move(source.warnings)};
}

}  // namespace alidade
