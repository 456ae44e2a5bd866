// SPDX-License-Identifier: MIT
// Encodings against bytes calculated by hand from the specifications. readers/parquet_test.sh tests that
// engines read whole files.
#include "extensions/parquet/write_parquet.h"

#include <tbb/task_arena.h>
#include <climits>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/output_file.h"
#include "cloud/las/write_las.h"
#include "extensions/parquet/column_chunk.h"
#include "extensions/parquet/encodings.h"
#include "extensions/parquet/thrift_writer.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

Bytes bytes_of(std::initializer_list<int> numbers) {
  Bytes bytes;
  for (const int number : numbers) bytes.push_back(static_cast<std::byte>(number));
  return bytes;
}

template <class Append>
Bytes made_by(const Append& append) {
  Bytes bytes;
  append(bytes);
  return bytes;
}

Bytes runs(const std::vector<std::uint32_t>& numbers, int width) {
  return made_by([&](Bytes& bytes) { append_runs(numbers, width, bytes); });
}

template <class Unsigned>
Bytes deltas(const std::vector<Unsigned>& numbers) {
  return made_by([&](Bytes& bytes) { append_deltas(std::span<const Unsigned>(numbers), bytes); });
}

TEST(ParquetEncodings, varints_have_seven_bits_per_byte) {
  const auto varint = [](std::uint64_t number) {
    return made_by([&](Bytes& bytes) { append_varint(number, bytes); });
  };
  EXPECT_EQ(varint(0), bytes_of({0}));
  EXPECT_EQ(varint(127), bytes_of({0x7f}));
  EXPECT_EQ(varint(300), bytes_of({0xac, 0x02}));
  EXPECT_EQ(varint(UINT64_MAX), bytes_of({255, 255, 255, 255, 255, 255, 255, 255, 255, 1}));
  EXPECT_EQ(zigzag(-1), 1u);
  EXPECT_EQ(zigzag(1), 2u);
  EXPECT_EQ(zigzag(std::numeric_limits<std::int64_t>::min()), UINT64_MAX);
}

TEST(ParquetEncodings, numbers_are_packed_from_the_lowest_bit_on) {
  const auto packed = [](const std::vector<std::uint64_t>& numbers, int width) {
    return made_by([&](Bytes& bytes) { append_packed(std::span(numbers), width, bytes); });
  };
  // The example of the specification: 0 to 7 in three bits each.
  EXPECT_EQ(packed({0, 1, 2, 3, 4, 5, 6, 7}, 3), bytes_of({0b10001000, 0b11000110, 0b11111010}));
  EXPECT_EQ(packed({0, 0}, 0), Bytes());
  EXPECT_EQ(packed({UINT64_MAX, 1}, 64),
            bytes_of({255, 255, 255, 255, 255, 255, 255, 255, 1, 0, 0, 0, 0, 0, 0, 0}));
  // The second number crosses from the first 64 bits to the next.
  EXPECT_EQ(packed({1, (std::uint64_t{1} << 40) - 1}, 40),
            bytes_of({1, 0, 0, 0, 0, 255, 255, 255, 255, 255}));
}

TEST(ParquetEncodings, runs_of_eight_are_counted_and_others_packed) {
  EXPECT_EQ(runs(std::vector<std::uint32_t>(100, 4), 3), bytes_of({(200 & 0x7f) | 0x80, 1, 4}));
  EXPECT_EQ(runs(std::vector<std::uint32_t>(8, 0x1234), 16), bytes_of({16, 0x34, 0x12}));
  EXPECT_EQ(runs({0, 1, 2, 3, 4, 5, 6, 7}, 3), bytes_of({3, 0x88, 0xc6, 0xfa}));
  // The last group is filled with zeros.
  EXPECT_EQ(runs({1, 0, 1}, 1), bytes_of({3, 0b101}));
  // A run that begins within a group counts from the next one on.
  std::vector<std::uint32_t> numbers = {0, 1, 0};
  numbers.insert(numbers.end(), 21, 1);
  numbers.push_back(0);
  EXPECT_EQ(runs(numbers, 1), bytes_of({3, 0b11111010, 16 << 1, 1, 3, 0}));
  EXPECT_EQ(runs({}, 4), Bytes());
}

TEST(ParquetEncodings, deltas_are_those_of_the_specification) {
  // Block of 128 in 4 parts, 5 values, first value 1; least delta 1, no bits.
  EXPECT_EQ(deltas<std::uint32_t>({1, 2, 3, 4, 5}), bytes_of({0x80, 1, 4, 5, 2, 2, 0, 0, 0, 0}));
  // Deltas -2 -2 -2 1 1 1 1, above the least one 0 0 0 3 3 3 3 in two bits, filled up to 32.
  EXPECT_EQ(deltas<std::uint32_t>({7, 5, 3, 1, 2, 3, 4, 5}),
            bytes_of({0x80, 1, 4, 8, 14, 3, 2, 0, 0, 0, 0b11000000, 0b00111111, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(deltas<std::uint64_t>({}), bytes_of({0x80, 1, 4, 0, 0}));
  EXPECT_EQ(deltas<std::uint64_t>({UINT64_MAX}), bytes_of({0x80, 1, 4, 1, 1}));
}

TEST(ParquetEncodings, deltas_wrap_around) {
  // From the least to the greatest number it is one step down.
  EXPECT_EQ(deltas<std::uint32_t>({0x80000000u, 0x7fffffffu}),
            bytes_of({0x80, 1, 4, 2, 255, 255, 255, 255, 15, 1, 0, 0, 0, 0}));
  EXPECT_EQ(deltas<std::uint64_t>({0, std::uint64_t{1} << 63, 0}).size(),
            5u + 10 + 4);  // the least delta is -2^63, twice
}

TEST(ParquetEncodings, structures_have_the_compact_form_of_thrift) {
  ThriftWriter writer;
  writer.structure([&] {
    writer.int32(1, -2);
    writer.int64(4, 300);
    writer.text(20, "ab");
    writer.structure(21, [&] {
      writer.boolean(1, true);
      writer.boolean(2, false);
      writer.byte(3, 7);
    });
    writer.list(22, ThriftWriter::Kind::int32, 2);
    writer.element(1);
    writer.element(-1);
    writer.list(23, ThriftWriter::Kind::structure, 20);
  });
  EXPECT_EQ(writer.bytes(), bytes_of({0x15, 3,    0x36, 0xd8, 4,    0x08, 40, 2, 'a',  'b',  0x1c, 0x11,
                                      0x12, 0x13, 7,    0,    0x19, 0x25, 2,  1, 0x19, 0xfc, 20,   0}));
}

template <class Value>
std::optional<std::array<Bytes, 2>> range(const std::vector<Value>& values) {
  return number_chunk(std::span<const Value>(values), {}).range;
}

template <class Value>
std::array<Bytes, 2> plain_pair(Value least, Value greatest) {
  return {made_by([&](Bytes& bytes) { append_value(least, bytes); }),
          made_by([&](Bytes& bytes) { append_value(greatest, bytes); })};
}

TEST(ParquetChunks, bounds_are_stated_only_where_readers_may_rely_on_them) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(range<double>({3.0, 1.0, infinity}), plain_pair(1.0, infinity));
  EXPECT_EQ(range<double>({3.0, nan, 1.0}), std::nullopt);
  EXPECT_EQ(range<double>({nan, 1.0}), std::nullopt);
  EXPECT_EQ(range<double>({}), std::nullopt);
  // Readers may take a zero of either sign for the other.
  EXPECT_EQ(range<double>({0.0, 0.0}), plain_pair(-0.0, 0.0));
  EXPECT_EQ(range<float>({-0.0f}), plain_pair(-0.0f, 0.0f));
  // Numbers without a sign are ordered as such.
  EXPECT_EQ(range<std::uint32_t>({4'000'000'000u, 1u}), plain_pair(1u, 4'000'000'000u));
  EXPECT_EQ(range<std::int64_t>({-1, 1}), plain_pair(std::int64_t{-1}, std::int64_t{1}));
}

TEST(ParquetChunks, the_smallest_encoding_is_chosen) {
  const auto encoding = [](const auto& values) { return number_chunk(std::span(values), {}).encoding; };
  std::vector<std::int64_t> rising(5000);
  std::iota(rising.begin(), rising.end(), 1'000'000'000'000);
  EXPECT_EQ(encoding(std::as_const(rising)), PageEncoding::deltas);
  std::vector<double> few, different;
  for (int i = 0; i < 5000; ++i) {
    few.push_back(0.1 * (i * i % 37));
    different.push_back(std::sin(i));
  }
  EXPECT_EQ(encoding(std::as_const(few)), PageEncoding::dictionary);
  EXPECT_EQ(encoding(std::as_const(different)), PageEncoding::plain);
}

class WriteParquetTest : public SqliteTest {
 protected:
  static void write(const std::filesystem::path& file, const PointCloud& cloud,
                    const ParquetOptions& options = {}) {
    OrderedCloud ordered(cloud);
    write_parquet(file, ordered, options);
  }
  std::size_t count_files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
  }
  static std::string bytes(const std::filesystem::path& file) {
    std::string content(std::filesystem::file_size(file), '\0');
    std::ifstream(file, std::ios::binary).read(content.data(), static_cast<std::streamsize>(content.size()));
    return content;
  }

  std::filesystem::path parquet_ = folder_ / "site.parquet";
};

TEST_F(WriteParquetTest, the_same_points_give_the_same_bytes) {
  write_las(folder_ / "site.las", site(3000));
  const CloudInputs files = resolve_clouds(std::vector{folder_ / "site.las"}, file_formats());
  write(parquet_, read_cloud(files));
  const std::filesystem::path other = folder_ / "other.parquet";
  for (const int threads : {1, 3}) {
    tbb::task_arena arena(threads);
    for (const std::uint64_t memory : {std::uint64_t{20'000}, std::uint64_t{1} << 30}) {
      arena.execute([&] {
        OrderedCloud ordered(folder_, files, {}, memory);
        EXPECT_EQ(ordered.points.size(), 3000u);
        write_parquet(other, ordered, {.overwrite = true});
      });
      EXPECT_TRUE(bytes(parquet_) == bytes(other)) << memory << " bytes, " << threads << " threads";
    }
  }
}

TEST_F(WriteParquetTest, a_file_appears_completely_or_not_at_all) {
  const PointCloud cloud = site(3000);
  int calls = 0, most = INT_MAX;
  const Progress watch = [&](std::uint64_t, std::uint64_t) { return ++calls < most; };
  write(parquet_, cloud, {.progress = watch});
  const int all = calls;
  EXPECT_GE(all, 2);
  const std::string before = bytes(parquet_);
  EXPECT_THROW(write(parquet_, cloud), Error);
  for (most = 1; most <= all; ++most) {
    calls = 0;
    EXPECT_THROW(write(parquet_, cloud, {.overwrite = true, .progress = watch}), Cancelled);
    EXPECT_TRUE(bytes(parquet_) == before);
    EXPECT_EQ(count_files(), 1u);
  }
}

/// Reads the compact protocol of Apache Thrift: numbers, texts and lists of a structure by a path of field
/// ids and list indices, such as "4/1/2" for field 2 of the second element of field 4.
class ThriftReader {
 public:
  explicit ThriftReader(std::string_view bytes) : bytes_(bytes) { take_structure(""); }

  std::int64_t number(const std::string& way) const { return numbers_.at(way); }
  const std::string& text(const std::string& way) const { return texts_.at(way); }
  bool has_text(const std::string& way) const { return texts_.contains(way); }
  bool has_number(const std::string& way) const { return numbers_.contains(way); }

 private:
  unsigned take_byte() { return static_cast<unsigned char>(bytes_.at(at_++)); }
  std::uint64_t take_varint() {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const unsigned byte = take_byte();
      value |= std::uint64_t{byte & 0x7f} << shift;
      if (byte < 0x80) return value;
    }
  }
  std::int64_t take_number() {
    const std::uint64_t value = take_varint();
    return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
  }
  void take_structure(const std::string& way) {
    std::int64_t id = 0;
    while (const unsigned head = take_byte()) {
      id = head >> 4 != 0 ? id + (head >> 4) : take_number();
      take(way + (way.empty() ? "" : "/") + std::to_string(id), static_cast<ThriftWriter::Kind>(head & 15));
    }
  }
  void take(const std::string& way, ThriftWriter::Kind kind) {
    using Kind = ThriftWriter::Kind;
    if (kind == Kind::structure) return take_structure(way);
    if (kind == Kind::byte) {
      numbers_[way] = take_byte();
    } else if (kind == Kind::int32 || kind == Kind::int64) {
      numbers_[way] = take_number();
    } else if (kind == Kind::binary) {
      const std::uint64_t size = take_varint();
      texts_[way] = bytes_.substr(at_, size);
      at_ += size;
    } else if (kind == Kind::list) {
      const unsigned head = take_byte();
      const std::uint64_t count = head >> 4 == 15 ? take_varint() : head >> 4;
      for (std::uint64_t i = 0; i < count; ++i)
        take(way + "/" + std::to_string(i), static_cast<Kind>(head & 15));
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::map<std::string, std::int64_t> numbers_;
  std::map<std::string, std::string> texts_;
};

/// The metadata of a file.
ThriftReader footer_of(const std::string& content) {
  std::uint32_t size = 0;
  std::memcpy(&size, content.data() + content.size() - 8, sizeof size);
  return ThriftReader(std::string_view(content).substr(content.size() - 8 - size, size));
}

template <class Value>
Value value_of(const std::string& bytes) {
  EXPECT_EQ(bytes.size(), sizeof(Value));
  Value value{};
  std::memcpy(&value, bytes.data(), std::min(bytes.size(), sizeof value));
  return value;
}

TEST_F(WriteParquetTest, statistics_of_every_group_hold_its_points_and_those_of_the_file_all) {
  const PointCloud cloud = site(5000);
  write(parquet_, cloud, {.group_points = 1024, .geometry = true});
  const std::string content = bytes(parquet_);
  const ThriftReader footer = footer_of(content);
  Bounds all;
  std::int64_t rows = 0, nulls = 0;
  int groups = 0;
  for (; footer.has_number(fmt::format("4/{}/3", groups)); ++groups) {
    const std::string group = fmt::format("4/{}/", groups);
    rows += footer.number(group + "3");
    Bounds box;
    std::int64_t end = footer.number(group + "5");
    for (int column = 0; footer.has_number(group + fmt::format("1/{}/3/1", column)); ++column) {
      const std::string about = group + fmt::format("1/{}/3/", column);
      const std::string& name = footer.text(about + "3/0");
      EXPECT_EQ(footer.number(about + "5"), footer.number(group + "3")) << name;
      // One column lies behind the other: a dictionary, if there is one, then the data.
      const bool has_dictionary = footer.has_number(about + "11");
      const std::int64_t data = footer.number(about + "9"),
                         dictionary = has_dictionary ? footer.number(about + "11") : data;
      EXPECT_EQ(dictionary, end) << name;
      EXPECT_EQ(data > dictionary, has_dictionary) << name;
      const auto kind_of_page = [&](std::int64_t at) {
        return ThriftReader(std::string_view(content).substr(static_cast<std::size_t>(at))).number("1");
      };
      EXPECT_EQ(kind_of_page(data), 0) << name;
      if (has_dictionary) EXPECT_EQ(kind_of_page(dictionary), 2) << name;
      end = dictionary + footer.number(about + "7");
      nulls += footer.number(about + "12/3");
      if (name == "x" || name == "y" || name == "z") {
        const int axis = name[0] - 'x';
        box.min[axis] = value_of<double>(footer.text(about + "12/6"));
        box.max[axis] = value_of<double>(footer.text(about + "12/5"));
        EXPECT_LT(box.min[axis], box.max[axis]);
      }
      EXPECT_EQ(footer.has_text(about + "12/5"), name != "geometry") << name;
      if (name == "Height") EXPECT_EQ(value_of<double>(footer.text(about + "12/5")), 0.01 * 199);
      if (name == "Height") EXPECT_EQ(value_of<double>(footer.text(about + "12/6")), 0.01);
    }
    EXPECT_EQ(end, footer.number(group + "5") + footer.number(group + "6"));
    all.grow(box);
  }
  EXPECT_EQ(groups, 5);
  EXPECT_EQ(rows, 5000);
  EXPECT_EQ(nulls, 25) << "every 200th height is 0, which stands for none";
  const Bounds exact = cloud.bounds();
  EXPECT_EQ(all.min, exact.min);
  EXPECT_EQ(all.max, exact.max);
  EXPECT_NE(content.find(fmt::format(R"("bbox":[{},{},{},{},{},{}])", exact.min.x, exact.min.y, exact.min.z,
                                     exact.max.x, exact.max.y, exact.max.z)),
            std::string::npos);
}

TEST_F(WriteParquetTest, thousands_of_columns_are_written_in_smaller_groups) {
  PointCloud cloud;
  cloud.positions.resize(2000);
  for (int i = 0; i < 10'000; ++i) {
    cloud.extra_dimensions.push_back(plain_dimension(fmt::format("dimension_{}", i), ScalarType::uint16));
    cloud.extra_dimensions.back().values.assign(2 * cloud.size(), static_cast<std::uint8_t>(i));
  }
  write(parquet_, cloud);
  const std::string content = bytes(parquet_);
  // Once in the schema, once in each of two groups.
  std::size_t count = 0;
  for (std::size_t at = 0; (at = content.find("dimension_9999", at)) != content.npos; ++at) ++count;
  EXPECT_EQ(count, 3u);
}

TEST_F(WriteParquetTest, metadata_is_text_whatever_a_cloud_says) {
  PointCloud cloud = site(10);
  cloud.crs.wkt = "LOCAL_CS[\"caf\xe9\"]";
  write(parquet_, cloud);
  EXPECT_EQ(bytes(parquet_).find("caf"), std::string::npos);
  cloud.crs.wkt = "LOCAL_CS[\"yard\"]";
  const auto projjson = [](const Crs& crs) {
    return crs.wkt.find("yard") == crs.wkt.npos ? "" : R"({"name":"yard"})";
  };
  write(parquet_, cloud, {.overwrite = true});
  EXPECT_NE(bytes(parquet_).find("LOCAL_CS[\"yard\"]"), std::string::npos);
  write(parquet_, cloud, {.geometry = true, .overwrite = true, .projjson = projjson});
  EXPECT_NE(bytes(parquet_).find(R"("crs":{"name":"yard"},"bbox":[)"), std::string::npos);
  cloud.extra_dimensions.front().name = "Geometry";
  write(parquet_, cloud, {.geometry = true, .overwrite = true});
  EXPECT_NE(bytes(parquet_).find(R"("primary_column":"geometry_","columns":{"geometry_":{)"),
            std::string::npos);
  write(parquet_, PointCloud(), {.geometry = true, .overwrite = true, .projjson = projjson});
  EXPECT_NE(bytes(parquet_).find(R"("crs":null}}})"), std::string::npos);
}

}  // namespace
}  // namespace alidade::test
