// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud/e57/e57_file.h"
#include "cloud/e57/e57_points.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/cloud/read_alone.h"

namespace alidade {
namespace {

using test::E57Builder;
using test::E57Column;
using test::expect_near;
using test::float32_column;
using test::float64_column;
using test::integer_column;
using test::pose_element;
using test::warns;

PointCloud read(const E57Builder& builder, AttributeSet wanted = AttributeSet::all()) {
  const std::string file = builder.file();
  return test::read_memory(std::as_bytes(std::span(file)), {.attributes = wanted});
}

std::vector<E57Column> three_points() {
  return {float64_column("cartesianX", {1, 2, 3}), float64_column("cartesianY", {10, 20, 30}),
          float64_column("cartesianZ", {100, 200, 300})};
}

TEST(Crc32c, of_the_digits_is_the_published_value) {
  const std::string digits = "123456789";
  EXPECT_EQ(crc32c(std::as_bytes(std::span(digits))), 0xE3069283u);
  EXPECT_EQ(crc32c({}), 0u);
}

TEST(BitQueue, numbers_of_every_width_are_cut_anywhere) {
  for (int width = 0; width <= 64; ++width) {
    E57Column column{"", width, {}};
    for (std::uint64_t i = 0; i < 50; ++i) {
      const std::uint64_t number = i * 0x9E3779B97F4A7C15u;
      column.numbers.push_back(width == 0 ? 0 : number >> (64 - width));
    }
    const std::string bytes = test::bit_packed(column);
    BitQueue queue(width);
    std::vector<std::uint64_t> found;
    for (std::size_t offset = 0, piece = 1; found.size() < 50; offset += piece, piece = piece % 11 + 1) {
      const std::string_view rest = std::string_view(bytes).substr(std::min(offset, bytes.size()), piece);
      queue.add(std::as_bytes(std::span(rest)));
      std::vector<std::uint64_t> numbers(queue.available(50 - found.size()));
      queue.take(numbers);
      found.insert(found.end(), numbers.begin(), numbers.end());
    }
    EXPECT_EQ(found, column.numbers) << "width " << width;
  }
}

TEST(BitQueue, restart_forgets_what_is_left_of_a_number) {
  const std::vector<std::byte> two = {std::byte{0x21}, std::byte{0x03}};
  BitQueue queue(12);
  queue.add(two);
  std::vector<std::uint64_t> number(1);
  EXPECT_FALSE(queue.restart()) << "an integer waits before the four bits";
  queue.take(number);
  EXPECT_EQ(number[0], 0x321u);
  EXPECT_TRUE(queue.restart());
  queue.add(two);
  queue.take(number);
  EXPECT_EQ(number[0], 0x321u);
}

TEST(E57Pages, views_anywhere_and_of_any_length_are_the_bytes_between_the_checksums) {
  E57Builder builder;
  std::string characters(300'000, ' ');
  for (std::size_t i = 0; i < characters.size(); ++i) characters[i] = static_cast<char>('!' + i * i % 89);
  builder.root = "<note type=\"String\">" + characters + "</note>";
  const std::string file = builder.file();
  std::string payload;
  for (std::size_t page = 0; page < file.size(); page += 1024) payload += file.substr(page, 1020);
  E57Pages pages(InputFile(std::as_bytes(std::span(file)), "memory"));
  std::uint64_t number = 1;
  for (int i = 0; i < 2000; ++i) {
    number = number * 6364136223846793005u + 1442695040888963407u;
    // Far jumps, steps forward and steps back.
    const std::uint64_t offset = i % 3 == 0 ? (number >> 33) % payload.size() : (number >> 33) % 70'000;
    const std::uint64_t count = std::min<std::uint64_t>((number >> 20) % 70'000, payload.size() - offset);
    const auto bytes = pages.view(offset, static_cast<std::size_t>(count));
    ASSERT_EQ(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
              std::string_view(payload).substr(offset, count));
    if (i % 97 == 0) pages.rest();
  }
}

TEST(E57, format_version_and_counts_are_read) {
  E57Builder builder;
  builder.add_scan("", three_points());
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.files[0].format, "E57");
  EXPECT_EQ(cloud.files[0].version, "1.0");
  ASSERT_EQ(cloud.size(), 3u);
  expect_near(cloud.world(1), {2, 20, 200}, 1e-6);
  EXPECT_TRUE(cloud.scanner_positions.empty()) << "without a pose nobody knows";
  EXPECT_TRUE(cloud.warnings.empty());
}

TEST(E57, is_detected_by_content) {
  E57Builder builder;
  builder.add_scan("", three_points());
  const std::string file = builder.file();
  EXPECT_EQ(test::read_memory(std::as_bytes(std::span(file))).files[0].format, "E57");
}

TEST(E57, poses_turn_then_move_and_are_the_positions_of_scanners) {
  E57Builder builder;
  // A quarter turn about z: x becomes y.
  builder.add_scan("<name type=\"String\"><![CDATA[gate]]></name>" +
                       pose_element("0.70710678118654757 0 0 0.70710678118654757", "1000 2000 50"),
                   three_points());
  builder.add_scan(pose_element("", "7 8 9"), three_points());
  builder.add_scan(pose_element("1 0 0 0", ""), three_points());
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 9u);
  expect_near(cloud.world(0), {990, 2001, 150}, 1e-5);
  expect_near(cloud.world(3), {8, 18, 109}, 1e-5);
  expect_near(cloud.world(6), {1, 10, 100}, 1e-5);
  ASSERT_EQ(cloud.scanner_positions.size(), 3u);
  EXPECT_EQ(cloud.scanner_positions[0], (ScannerPosition{"gate", {1000, 2000, 50}}));
  EXPECT_EQ(cloud.scanner_positions[1], (ScannerPosition{"", {7, 8, 9}}));
  EXPECT_EQ(cloud.scanner_positions[2].position, glm::dvec3(0.0));
}

TEST(E57, quaternions_of_another_length_are_normalized_with_a_warning) {
  E57Builder builder;
  builder.add_scan(pose_element("2 0 0 2", "0 0 0"), three_points());
  const PointCloud cloud = read(builder);
  expect_near(cloud.world(0), {-10, 1, 100}, 1e-6);
  EXPECT_TRUE(warns(cloud, "the quaternion of the pose has length 2.8"));
}

TEST(E57, what_is_odd_in_many_scans_is_reported_once) {
  E57Builder builder;
  for (int i = 0; i < 5; ++i) {
    std::vector<E57Column> columns = three_points();
    columns.push_back(float32_column("intensity", {0, 1, 2.0 + i}, "minimum=\"0\" maximum=\"1\""));
    builder.add_scan(pose_element(i == 0 ? "1 0 0 0" : "2 0 0 2", "0 0 0"), columns);
    builder.add_image("");
  }
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.warnings.size(), 3u);
  EXPECT_TRUE(warns(cloud, "memory: scan 2: the quaternion of the pose has length 2.8"));
  EXPECT_TRUE(warns(cloud, "normalized, and 3 more like this"));
  EXPECT_TRUE(warns(cloud, "memory: image 1 contains no image, and 4 more like this"));
  EXPECT_TRUE(warns(cloud,
                    "scan 1: intensities from 0 to 2 exceed the stated range of 0 to 1: using 0 to 2, and 4 "
                    "more like this"));
}

TEST(E57, spherical_coordinates_with_a_pose) {
  const double pi = 3.14159265358979323846;
  E57Builder builder;
  builder.add_scan(pose_element("0 1 0 0", "5 0 0"),  // half a turn about x
                   {float64_column("sphericalRange", {2, 2, 2, 2}),
                    float64_column("sphericalAzimuth", {0, pi / 2, 0, -3 * pi / 4}),
                    float64_column("sphericalElevation", {0, 0, pi / 2, pi / 4})});
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 4u);
  expect_near(cloud.world(0), {7, 0, 0}, 1e-8);
  expect_near(cloud.world(1), {5, -2, 0}, 1e-8);
  expect_near(cloud.world(2), {5, 0, -2}, 1e-8);
  expect_near(cloud.world(3), {4, 1, -std::sqrt(2.0)}, 1e-8);
}

TEST(E57, scaled_integers_of_1_to_63_bits_in_packets_that_cut_them) {
  for (int bits = 1; bits <= 63; ++bits) {
    const std::int64_t most = static_cast<std::int64_t>((std::uint64_t{1} << bits) - 1);
    std::vector<std::int64_t> values;
    for (std::uint64_t i = 0; i < 100; ++i)
      values.push_back(static_cast<std::int64_t>((i * 0x9E3779B97F4A7C15u) >> (64 - bits)));
    values.push_back(most);
    values.push_back(0);
    std::vector<std::int64_t> shifted;
    for (const std::int64_t value : values) shifted.push_back(value - most / 2);
    const std::vector<std::int64_t> constant(values.size(), 17);
    E57Builder builder;
    builder.add_scan("",
                     {integer_column("cartesianX", 0, most, values, " scale=\"0.001\""),
                      integer_column("cartesianY", -(most / 2), most - most / 2, shifted,
                                     " scale=\"0.5\" offset=\"1000\""),
                      integer_column("cartesianZ", 17, 17, constant, " scale=\"0.01\" offset=\"3\"")},
                     13);
    const PointCloud cloud = read(builder);
    ASSERT_EQ(cloud.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double x = static_cast<double>(values[i]) * 0.001;
      const double y = static_cast<double>(shifted[i]) * 0.5 + 1000;
      const glm::dvec3 world = cloud.world(i);
      // 32 bits of the lattice hold the first 30 exactly.
      EXPECT_NEAR(world.x, x, bits <= 30 ? 1e-9 : 0.51 * cloud.lattice.scale.x) << bits;
      EXPECT_NEAR(world.y, y, bits <= 26 ? 1e-6 : 0.51 * cloud.lattice.scale.y) << bits;
      EXPECT_NEAR(world.z, 3.17, 1e-12);
    }
  }
}

TEST(E57, integers_of_64_bits_have_no_stated_ends) {
  E57Builder builder;
  std::vector<E57Column> columns = three_points();
  columns[0] = {"<cartesianX type=\"Integer\"/>", 64, {}};
  for (const std::int64_t value : {-5, 0, 123456})
    columns[0].numbers.push_back(static_cast<std::uint64_t>(value) + (std::uint64_t{1} << 63));
  builder.add_scan("", columns);
  const PointCloud cloud = read(builder);
  EXPECT_NEAR(cloud.world(0).x, -5, 1e-9);
  EXPECT_NEAR(cloud.world(2).x, 123456, 1e-9);
}

TEST(E57, constant_fields_take_no_bytes_and_count_as_often_as_the_record_count_says) {
  E57Builder builder;
  builder.add_scan("",
                   {integer_column("cartesianX", 4, 4, {4, 4}), integer_column("cartesianY", 5, 5, {5, 5}),
                    integer_column("cartesianZ", 6, 6, {6, 6})});
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(1), {4, 5, 6}, 0);
}

TEST(E57, fields_have_any_order_and_scans_have_fields_of_their_own) {
  E57Builder builder;
  builder.add_scan(
      "", {integer_column("colorBlue", 0, 255, {3, 6, 9}), float64_column("cartesianZ", {100, 200, 300}),
           integer_column("other:thing", 0, 7, {1, 2, 3}), float64_column("cartesianX", {1, 2, 3}),
           integer_column("colorRed", 0, 255, {1, 4, 7}), float64_column("cartesianY", {10, 20, 30}),
           integer_column("colorGreen", 0, 255, {2, 5, 8})});
  builder.add_scan("", three_points());
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 6u);
  expect_near(cloud.world(2), {3, 30, 300}, 1e-6);
  EXPECT_EQ(cloud.colors[2], Color16(7 * 257, 8 * 257, 9 * 257));
  EXPECT_EQ(cloud.colors[3], Color16(0, 0, 0));
  EXPECT_TRUE(warns(cloud, "skipped the fields \"other:thing\""));
}

TEST(E57, fields_that_are_not_read_are_all_named_up_to_twenty) {
  std::vector<E57Column> columns = three_points();
  for (int i = 10; i < 33; ++i)
    columns.push_back(integer_column("las:aFieldOfItsOwn" + std::to_string(i), 0, 1, {0, 0, 0}));
  E57Builder builder;
  builder.add_scan("", columns);
  const PointCloud cloud = read(builder);
  EXPECT_TRUE(warns(cloud, "skipped the fields \"las:aFieldOfItsOwn10\", \"las:aFieldOfItsOwn11\","));
  EXPECT_TRUE(warns(cloud, "\"las:aFieldOfItsOwn29\" and 3 more"));
}

TEST(E57, index_and_empty_packets_are_skipped) {
  const std::vector<E57Column> columns = three_points();
  std::vector<std::string> packets = test::packets_of(columns, 9);
  const std::string index = std::string("\0\0\x1f\0\0\0", 6) + std::string(26, '\0');
  const std::string empty("\2\0\7\0\0\0\0\0", 8);
  packets.insert(packets.begin(), index);
  packets.insert(packets.begin() + 2, empty);
  packets.push_back(index);
  E57Builder builder;
  builder.add_scan("", columns, packets, 3);
  expect_near(read(builder).world(2), {3, 30, 300}, 1e-6);
}

TEST(E57, packets_without_bytes_for_a_field_and_streams_one_after_another) {
  const std::vector<E57Column> columns = three_points();
  std::vector<std::string> packets;
  for (std::size_t stream = 0; stream < 3; ++stream) {
    const std::string bytes = test::bit_packed(columns[stream]);
    std::vector<std::string_view> pieces(3);
    pieces[stream] = bytes;
    packets.push_back(test::data_packet(pieces));
  }
  E57Builder builder;
  builder.add_scan("", columns, packets, 3);
  expect_near(read(builder).world(2), {3, 30, 300}, 1e-6);
}

TEST(E57, sections_across_pages_are_read_without_their_checksums) {
  std::vector<double> x(5000), y(5000), z(5000);
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = 0.5 * static_cast<double>(i);
    y[i] = static_cast<double>(i % 7);
    z[i] = static_cast<double>(i % 11);
  }
  E57Builder builder;
  builder.add_scan("", three_points());
  builder.add_scan(
      "", {float64_column("cartesianX", x), float64_column("cartesianY", y), float64_column("cartesianZ", z)},
      1001);
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 5003u);
  for (std::size_t i = 0; i < x.size(); ++i) expect_near(cloud.world(i + 3), {x[i], y[i], z[i]}, 1e-5);
}

TEST(E57, scans_without_records_are_ignored) {
  E57Builder builder;
  builder.add_scan_element("", "", 0, 0);
  builder.add_scan_element("", "<cartesianX type=\"Float\"/>", 99999999, 0);
  EXPECT_EQ(read(builder).size(), 0u);
  builder.add_scan("", three_points());
  EXPECT_EQ(read(builder).size(), 3u);
}

TEST(E57, only_wanted_attributes_are_kept) {
  E57Builder builder;
  std::vector<E57Column> columns = three_points();
  columns.push_back(integer_column("intensity", 0, 255, {0, 100, 255}));
  columns.push_back(integer_column("rowIndex", 0, 9, {1, 2, 3}));
  builder.add_scan("", columns);
  EXPECT_EQ(read(builder).attributes(), Attribute::intensity | Attribute::extra_dimensions);
  EXPECT_EQ(read(builder, Attribute::intensity).attributes(), AttributeSet(Attribute::intensity));
  EXPECT_EQ(read(builder, {}).attributes(), AttributeSet());
}

TEST(E57, coordinate_metadata_are_the_reference_system_if_they_are_wkt) {
  E57Builder builder;
  builder.add_scan("", three_points());
  builder.root =
      "<coordinateMetadata type=\"String\"><![CDATA[PROJCS[\"here\",UNIT[\"m\",1]] ]]></coordinateMetadata>";
  EXPECT_EQ(read(builder).crs.wkt, "PROJCS[\"here\",UNIT[\"m\",1]]");
  builder.root = "<coordinateMetadata type=\"String\">somewhere near</coordinateMetadata>";
  const PointCloud cloud = read(builder);
  EXPECT_TRUE(cloud.crs.empty());
  EXPECT_TRUE(warns(cloud, "the coordinate metadata is not WKT and was ignored: \"somewhere near\""));
}

TEST(E57, progress_is_reported_and_can_stop) {
  E57Builder builder;
  builder.add_scan("", three_points());
  const std::string file = builder.file();
  EXPECT_THROW(test::read_memory(std::as_bytes(std::span(file)),
                                 {.progress = [](std::uint64_t, std::uint64_t) { return false; }}),
               Cancelled);
}

}  // namespace
}  // namespace alidade
