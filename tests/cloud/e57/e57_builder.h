// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/e57/e57_file.h"

// Small E57 files, byte by byte as ASTM E2807 has them, so that readers meet what no sample file shows.

namespace alidade::test {

/// Gives every whole page the checksum of its bytes.
inline void seal_e57(std::span<std::byte> file) {
  for (std::size_t page = 0; page + 1024 <= file.size(); page += 1024) {
    const std::uint32_t sum = crc32c(file.subspan(page, 1020));
    for (unsigned i = 0; i < 4; ++i) file[page + 1020 + i] = static_cast<std::byte>(sum >> (24 - 8 * i));
  }
}

/// A field of a scan: its element in the prototype, and its values as they are stored.
struct E57Column {
  std::string element;
  int width = 0;  ///< bits
  std::vector<std::uint64_t> numbers;
};

inline E57Column float64_column(const std::string& name, const std::vector<double>& values,
                                const std::string& attributes = "") {
  E57Column column{"<" + name + " type=\"Float\" " + attributes + "/>", 64, {}};
  for (const double value : values) column.numbers.push_back(std::bit_cast<std::uint64_t>(value));
  return column;
}

inline E57Column float32_column(const std::string& name, const std::vector<double>& values,
                                const std::string& attributes = "") {
  E57Column column{"<" + name + " type=\"Float\" precision=\"single\" " + attributes + "/>", 32, {}};
  for (const double value : values)
    column.numbers.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
  return column;
}

/// `scale` as in ` scale="0.001" offset="5"` makes scaled integers.
inline E57Column integer_column(const std::string& name, std::int64_t minimum, std::int64_t maximum,
                                const std::vector<std::int64_t>& values, const std::string& scale = "") {
  const std::uint64_t spread = static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum);
  E57Column column{"<" + name + " type=\"" + (scale.empty() ? "Integer" : "ScaledInteger") + "\" minimum=\"" +
                       std::to_string(minimum) + "\" maximum=\"" + std::to_string(maximum) + "\"" + scale +
                       "/>",
                   static_cast<int>(std::bit_width(spread)),
                   {}};
  for (const std::int64_t value : values)
    column.numbers.push_back(static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(minimum));
  return column;
}

/// The numbers one after another, lowest bits first.
inline std::string bit_packed(const E57Column& column) {
  std::string bytes((column.numbers.size() * static_cast<std::size_t>(column.width) + 7) / 8, '\0');
  std::size_t bit = 0;
  for (const std::uint64_t number : column.numbers) {
    for (int i = 0; i < column.width; ++i, ++bit) {
      if ((number >> i & 1) != 0)
        bytes[bit / 8] = static_cast<char>(static_cast<unsigned char>(bytes[bit / 8]) | (1u << bit % 8));
    }
  }
  return bytes;
}

template <class Value>
std::string bytes_of(Value value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

/// A data packet with these pieces of the streams.
inline std::string data_packet(const std::vector<std::string_view>& pieces, unsigned flags = 0) {
  std::string body;
  for (const std::string_view piece : pieces) body += bytes_of(static_cast<std::uint16_t>(piece.size()));
  for (const std::string_view piece : pieces) body += piece;
  body.resize((6 + body.size() + 3) / 4 * 4 - 6, '\0');
  return std::string(1, '\1') + static_cast<char>(flags) +
         bytes_of(static_cast<std::uint16_t>(body.size() + 5)) +
         bytes_of(static_cast<std::uint16_t>(pieces.size())) + body;
}

/// The packets of a scan: of stream i, packet by packet, `piece` + i bytes, so that streams run apart and
/// values are cut anywhere.
inline std::vector<std::string> packets_of(const std::vector<E57Column>& columns, std::size_t piece) {
  std::vector<std::string> streams;
  for (const E57Column& column : columns) streams.push_back(bit_packed(column));
  std::vector<std::string_view> left(streams.begin(), streams.end());
  std::vector<std::string> packets;
  do {
    std::vector<std::string_view> pieces;
    for (std::size_t i = 0; i < left.size(); ++i) {
      pieces.push_back(left[i].substr(0, std::min(piece + i, left[i].size())));
      left[i].remove_prefix(pieces.back().size());
    }
    packets.push_back(data_packet(pieces));
  } while (std::ranges::any_of(left, [](std::string_view rest) { return !rest.empty(); }));
  return packets;
}

/// Puts an E57 file together.
class E57Builder {
 public:
  std::string root;  ///< further elements of e57Root
  std::string prolog = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

  /// A scan; `facts` are elements beside its points.
  void add_scan(const std::string& facts, const std::vector<E57Column>& columns, std::size_t piece = 4000) {
    add_scan(facts, columns, packets_of(columns, piece), columns.empty() ? 0 : columns[0].numbers.size());
  }

  /// A scan with these packets and record count, whatever the columns hold.
  void add_scan(const std::string& facts, const std::vector<E57Column>& columns,
                const std::vector<std::string>& packets, std::uint64_t record_count) {
    std::string prototype;
    for (const E57Column& column : columns) prototype += column.element;
    add_scan_element(facts, prototype, add_section(packets), record_count);
  }

  /// A scan whose section is somewhere already.
  void add_scan_element(const std::string& facts, const std::string& prototype, std::uint64_t offset,
                        std::uint64_t record_count) {
    scans_ += "<vectorChild type=\"Structure\">" + facts + "<points type=\"CompressedVector\" fileOffset=\"" +
              std::to_string(offset) + "\" recordCount=\"" + std::to_string(record_count) +
              "\"><prototype type=\"Structure\">" + prototype +
              "</prototype><codecs type=\"Vector\"></codecs></points></vectorChild>\n";
  }

  /// A section of points; returns its offset in the file, checksums counted.
  std::uint64_t add_section(const std::vector<std::string>& packets) {
    std::uint64_t length = 32;
    for (const std::string& packet : packets) length += packet.size();
    const std::uint64_t begin = payload_.size();
    payload_ += std::string("\1\0\0\0\0\0\0\0", 8) + bytes_of(length) + bytes_of(physical(begin + 32)) +
                bytes_of(std::uint64_t{0});
    for (const std::string& packet : packets) payload_ += packet;
    return physical(begin);
  }

  /// A file inside the file; returns the attributes of its element.
  std::string add_blob(std::string_view bytes) {
    const std::uint64_t begin = payload_.size();
    const std::size_t padded = (bytes.size() + 3) / 4 * 4;
    payload_ += std::string(8, '\0') + bytes_of(std::uint64_t{16 + padded});
    payload_ += bytes;
    payload_.append(padded - bytes.size(), '\0');
    return " type=\"Blob\" fileOffset=\"" + std::to_string(physical(begin)) + "\" length=\"" +
           std::to_string(bytes.size()) + "\"";
  }

  void add_image(const std::string& elements) {
    images_ += "<vectorChild type=\"Structure\">" + elements + "</vectorChild>\n";
  }

  std::string xml() const {
    return prolog + "<e57Root type=\"Structure\" xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">" +
           "<formatName type=\"String\"><![CDATA[ASTM E57 3D Imaging Data File]]></formatName>"
           "<guid type=\"String\"><![CDATA[{made by hand}]]></guid><versionMajor type=\"Integer\">1"
           "</versionMajor><versionMinor type=\"Integer\"/>" +
           root + "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">" + scans_ +
           "</data3D><images2D type=\"Vector\" allowHeterogeneousChildren=\"1\">" + images_ +
           "</images2D></e57Root>\n";
  }

  std::string file() const { return file_with(xml()); }

  /// The file with another XML.
  std::string file_with(std::string xml) const {
    std::string payload = payload_;
    const std::uint64_t offset = physical(payload.size());
    xml.resize((xml.size() + 3) / 4 * 4, ' ');
    payload += xml;
    payload.resize((payload.size() + 1019) / 1020 * 1020, '\0');
    const std::string header = "ASTM-E57" + bytes_of(std::uint32_t{1}) + bytes_of(std::uint32_t{0}) +
                               bytes_of(std::uint64_t{payload.size() / 1020 * 1024}) + bytes_of(offset) +
                               bytes_of(std::uint64_t{xml.size()}) + bytes_of(std::uint64_t{1024});
    payload.replace(0, header.size(), header);
    std::string file;
    for (std::size_t page = 0; page < payload.size(); page += 1020)
      file += payload.substr(page, 1020) + std::string(4, '\0');
    seal_e57(std::as_writable_bytes(std::span(file)));
    return file;
  }

 private:
  static std::uint64_t physical(std::uint64_t offset) { return offset + 4 * (offset / 1020); }

  std::string payload_ = std::string(48, '\0');
  std::string scans_, images_;
};

inline std::string pose_element(const std::string& rotation, const std::string& translation) {
  const auto parts = [](const std::string& names, const std::string& numbers) {
    std::string text;
    std::size_t offset = 0;
    for (const char name : names) {
      const std::size_t end = std::min(numbers.find(' ', offset), numbers.size());
      text += std::string("<") + name + " type=\"Float\">" + numbers.substr(offset, end - offset) + "</" +
              name + ">";
      offset = end + 1;
    }
    return text;
  };
  std::string text = "<pose type=\"Structure\">";
  if (!rotation.empty()) text += "<rotation type=\"Structure\">" + parts("wxyz", rotation) + "</rotation>";
  if (!translation.empty())
    text += "<translation type=\"Structure\">" + parts("xyz", translation) + "</translation>";
  return text + "</pose>";
}

}  // namespace alidade::test
