// SPDX-License-Identifier: MIT
#include <functional>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/cloud/read_alone.h"

namespace alidade {
namespace {

using test::E57Builder;
using test::E57Column;
using test::float64_column;
using test::integer_column;

std::vector<E57Column> three_points() {
  return {float64_column("cartesianX", {1, 2, 3}), float64_column("cartesianY", {10, 20, 30}),
          float64_column("cartesianZ", {100, 200, 300})};
}

std::string prototype_of(const std::vector<E57Column>& columns) {
  std::string text;
  for (const E57Column& column : columns) text += column.element;
  return text;
}

std::string sealed(std::string file) {
  test::seal_e57(std::as_writable_bytes(std::span(file)));
  return file;
}

void expect_error(const std::string& file, const std::string& part) {
  const std::string error = test::reading_error(open_e57, file);
  EXPECT_NE(error.find(part), std::string::npos) << "expected: " << part << "\nfound: " << error;
}

std::string sample() {
  E57Builder builder;
  builder.add_scan("", three_points());
  return builder.file();
}

/// The file with a value put at a byte, checksums made right.
template <class Value>
std::string with(std::string file, std::size_t offset, Value value) {
  file.replace(offset, sizeof value, test::bytes_of(value));
  return sealed(file);
}

TEST(E57Malformed, headers) {
  const std::string file = sample();
  expect_error(with(file, 8, std::uint32_t{2}), "header: unsupported E57 version; expected 1.x, found 2.0");
  expect_error(with(file, 16, std::uint64_t{1}), "header: wrong file size");
  expect_error(with(file, 24, std::uint64_t{1022}),
               "header: invalid offset of the XML; expected an offset outside checksums");
  expect_error(with(file, 24, std::uint64_t{1} << 60),
               "header: invalid offset of the XML; expected less than");
  expect_error(with(file, 32, std::uint64_t{0}), "header: the XML exceeds the file");
  expect_error(with(file, 32, ~std::uint64_t{0}), "header: the XML exceeds the file");
  expect_error(with(file, 40, std::uint64_t{4096}), "header: unsupported page size");
  expect_error("ASTM-E57", "header: truncated file");
  expect_error(std::string(2048, 'x'), "header: not an E57 file");
}

TEST(E57Malformed, a_damaged_page_is_named) {
  E57Builder builder;
  builder.add_scan("<description type=\"String\">" + std::string(3000, '.') + "</description>",
                   three_points());
  std::string file = builder.file();
  file[2100] ^= 1;
  expect_error(file, "memory:page 2: corrupt page: wrong checksum");
}

TEST(E57Malformed, every_prefix_is_an_error) {
  const std::string file = sample();
  EXPECT_EQ(test::count_readable_prefixes(open_e57, file), 0u);
}

TEST(E57Malformed, changed_bytes_under_right_checksums_are_errors_or_other_clouds) {
  const std::string file = sample();
  std::size_t rejected = 0, read = 0;
  for (std::size_t offset = 0; offset < file.size(); ++offset) {
    for (const int change : {1, 0x80, 0xff}) {
      std::string changed = file;
      changed[offset] = static_cast<char>(changed[offset] ^ change);
      SCOPED_TRACE(offset);
      try {
        // A point has 24 bytes at least.
        EXPECT_LE(24 * test::read_alone(open_e57, sealed(changed)).size(), file.size());
        ++read;
      } catch (const Error& error) {
        EXPECT_EQ(error.parts().file, "memory") << error.what();
        EXPECT_NE(error.parts().location, "") << error.what();
        ++rejected;
      }
    }
  }
  EXPECT_GT(rejected, file.size() / 2);
  EXPECT_GT(read, file.size() / 2);
}

TEST(E57Malformed, sections) {
  const std::vector<E57Column> columns = three_points();
  const auto file_at = [&](std::uint64_t offset, std::uint64_t count) {
    E57Builder builder;
    builder.add_section(test::packets_of(columns, 100));
    builder.add_scan_element("", prototype_of(columns), offset, count);
    return builder.file();
  };
  EXPECT_EQ(test::reading_error(open_e57, file_at(48, 3)), "");
  expect_error(file_at(1 << 20, 3), "scan 1: invalid offset of the section of points; expected less than");
  expect_error(file_at(1021, 3),
               "scan 1: invalid offset of the section of points; expected an offset outside");
  expect_error(file_at(80, 3), "scan 1: ");
  expect_error(file_at(48, 1000), "scan 1: the scan has more points than its section can hold");
  expect_error(file_at(48, ~std::uint64_t{0}), "scan 1: the scan has more points than its section can hold");
  const std::string sound = file_at(48, 3);
  expect_error(with(sound, 48, std::uint8_t{2}), "scan 1: wrong id of the section of points");
  expect_error(with(sound, 56, ~std::uint64_t{0}), "scan 1: the section of points exceeds the file");
  expect_error(with(sound, 56, std::uint64_t{31}), "scan 1: the section of points exceeds the file");
  expect_error(with(sound, 64, std::uint64_t{48}), "scan 1: the first packet is outside the section");
  expect_error(with(sound, 64, std::uint64_t{500}), "scan 1: the first packet is outside the section");
}

TEST(E57Malformed, packets) {
  const std::vector<E57Column> columns = three_points();
  const auto read = [&](const std::vector<std::string>& packets) {
    E57Builder builder;
    builder.add_scan("", columns, packets, 3);
    return builder.file();
  };
  const std::string sound = test::packets_of(columns, 100)[0];
  const auto changed = [&](std::size_t offset, std::uint16_t value) {
    std::string packet = sound;
    packet.replace(offset, 2, test::bytes_of(value));
    return read({packet});
  };
  EXPECT_EQ(test::reading_error(open_e57, read({sound})), "");
  expect_error(changed(0, 3), "scan 1, packet 1: unknown packet type");
  expect_error(changed(2, 0), "scan 1, packet 1: invalid packet length; expected a multiple of 4, found 1");
  expect_error(changed(2, 7), "scan 1, packet 1: the packet is too short for its streams");
  expect_error(changed(2, 3), "scan 1, packet 1: the packet is too short");
  expect_error(changed(2, 999), "scan 1, packet 1: the packet exceeds its section");
  expect_error(changed(4, 2), "scan 1, packet 1: wrong number of streams");
  expect_error(changed(8, 60000), "scan 1, packet 1: the packet is too short for its stream of cartesianY");
  const std::string nothing = test::data_packet({"", "", ""});
  expect_error(read(std::vector<std::string>(10, nothing)),
               "scan 1, packet 10: truncated section; expected 3 records, found 0");
}

TEST(E57Malformed, a_restart_ends_the_bytes_of_numbers_below_8_bits) {
  std::vector<E57Column> columns = three_points();
  columns.push_back(integer_column("rowIndex", 0, 3, {}));
  const auto read = [&](std::string_view rows) {
    std::vector<std::string> streams;
    for (std::size_t i = 0; i < 3; ++i) streams.push_back(test::bit_packed(columns[i]));
    const std::string more = test::bit_packed(integer_column("", 0, 3, {1}));
    const auto part = [&](std::size_t stream, std::size_t begin, std::size_t count) {
      return std::string_view(streams[stream]).substr(8 * begin, 8 * count);
    };
    const std::vector<std::string> packets = {
        test::data_packet({part(0, 0, 2), part(1, 0, 2), part(2, 0, 2), rows}),
        test::data_packet({part(0, 2, 1), part(1, 2, 1), part(2, 2, 1), more}, 1)};
    E57Builder builder;
    builder.add_scan("", columns, packets, 3);
    return builder.file();
  };
  const std::string two = test::bit_packed(integer_column("", 0, 3, {3, 2}));
  const PointCloud cloud = test::read_alone(open_e57, read(two));
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 1), 2u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 2), 1u) << "not of the bits that fill a byte";
  expect_error(read(two + std::string(1, '\0')),
               "scan 1, packet 2: unexpected compressor restart inside the records of rowIndex");
}

TEST(E57Malformed, a_restart_inside_records_is_an_error) {
  std::vector<E57Column> columns = three_points();
  columns[0] = integer_column("cartesianX", 0, 4095, {1, 2, 3});
  const std::string x = test::bit_packed(columns[0]), y = test::bit_packed(columns[1]);
  const std::string z = test::bit_packed(columns[2]);
  const auto read = [&](std::size_t first) {
    const std::vector<std::string> packets = {
        test::data_packet({std::string_view(x).substr(0, first), "", ""}),
        test::data_packet({std::string_view(x).substr(first), y, z}, 1)};
    E57Builder builder;
    builder.add_scan("", columns, packets, 3);
    return test::reading_error(open_e57, builder.file());
  };
  EXPECT_EQ(read(0), "");
  EXPECT_EQ(read(3), "") << "two whole numbers wait";
  EXPECT_NE(read(2).find("scan 1, packet 2: unexpected compressor restart inside the records of cartesianX"),
            std::string::npos);
}

TEST(E57Malformed, scans_that_share_a_section_are_an_error) {
  const std::vector<E57Column> columns = three_points();
  E57Builder builder;
  const std::uint64_t offset = builder.add_section(test::packets_of(columns, 100));
  for (int i = 0; i < 1000; ++i) builder.add_scan_element("", prototype_of(columns), offset, 3);
  expect_error(builder.file(), "the section overlaps that of scan");
}

TEST(E57Malformed, constants_are_not_counted_without_end) {
  const std::vector<E57Column> columns = {integer_column("cartesianX", 1, 1, {}),
                                          integer_column("cartesianY", 1, 1, {}),
                                          integer_column("cartesianZ", 1, 1, {})};
  E57Builder builder;
  builder.add_scan("", columns, test::packets_of(columns, 100), std::uint64_t{1} << 40);
  expect_error(builder.file(), "scan 1: the scan has more points than its section can hold");
}

TEST(E57Malformed, prototypes) {
  const auto read = [](const std::string& prototype) {
    E57Builder builder;
    const std::uint64_t offset = builder.add_section(test::packets_of(three_points(), 100));
    builder.add_scan_element("", prototype, offset, 1);
    return builder.file();
  };
  const std::string xyz = prototype_of(three_points());
  expect_error(read(""), "scan 1: missing coordinates");
  expect_error(read("<cartesianX type=\"Float\"/>"), "scan 1: missing coordinates");
  expect_error(read(xyz + "<a type=\"Blob\"/>"), "scan 1: unsupported type of \"a\"");
  expect_error(read(xyz + "<a type=\"Integer\" minimum=\"2\" maximum=\"1\"/>"),
               "the minimum exceeds the maximum of \"a\"");
  expect_error(read(xyz + "<a type=\"Integer\" minimum=\"x\"/>"),
               "invalid minimum of \"a\"; expected an integer");
  expect_error(read(xyz + "<a type=\"ScaledInteger\" scale=\"inf\"/>"),
               "invalid scale of \"a\"; expected a finite number");
  expect_error(read(xyz + "<a type=\"Float\" precision=\"half\"/>"), "unknown precision");
  expect_error(read(xyz + xyz), "duplicate field name");
  std::string deep, many;
  for (int i = 0; i < 100; ++i) deep += "<s type=\"Structure\">";
  deep += "<a type=\"Float\"/>";
  for (int i = 0; i < 100; ++i) deep += "</s>";
  expect_error(read(deep), "too many nested levels");
  for (int i = 0; i < 5000; ++i) many += "<f" + std::to_string(i) + " type=\"Float\"/>";
  expect_error(read(many), "too many fields");
  // Each field of a structure carries its name, so that a long one would be kept thousands of times.
  const std::string longer(200, 's');
  expect_error(
      read(xyz + "<" + longer + " type=\"Structure\"><" + longer + " type=\"Float\"/></" + longer + ">"),
      "expected at most 256 bytes, found 401");
}

TEST(E57Malformed, poses_and_codecs) {
  E57Builder builder;
  builder.add_scan(test::pose_element("0 0 0 0", "1 2 3"), three_points());
  expect_error(builder.file(), "scan 1: invalid value of \"rotation\"");
  E57Builder words;
  words.add_scan(test::pose_element("1 0 0 0", "1 2 far"), three_points());
  expect_error(words.file(), "invalid value of \"z\"; expected a finite number, found \"far\"");
  E57Builder sound;
  sound.add_scan("", three_points());
  std::string xml = sound.xml();
  xml.replace(xml.find("</codecs>"), 0, "<vectorChild type=\"Structure\"/>");
  expect_error(sound.file_with(xml), "unsupported compression");
}

TEST(E57Malformed, xml) {
  E57Builder builder;
  builder.add_scan("", three_points());
  expect_error(builder.file_with("<e57Root>"), "XML, byte ");
  expect_error(builder.file_with("<other/>"), "XML: missing element e57Root");
  builder.prolog = "<!DOCTYPE bomb [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;\">]>";
  expect_error(builder.file(), "XML: unsupported document type");
  std::string deep = "<e57Root>";
  for (int i = 0; i < 200000; ++i) deep += "<a>";
  for (int i = 0; i < 200000; ++i) deep += "</a>";
  EXPECT_EQ(test::reading_error(open_e57, builder.file_with(deep + "</e57Root>")), "")
      << "no scans, no points";
  expect_error(builder.file_with("<e57Root>" + std::string(9'000'000, '<')), "XML: too many elements");
}

}  // namespace
}  // namespace alidade
