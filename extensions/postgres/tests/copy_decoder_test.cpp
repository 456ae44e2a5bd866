// SPDX-License-Identifier: MIT
// What servers send is read wherever it is cut, and checked: counts, lengths, its end.
#include "extensions/postgres/copy_format.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "cloud/rows.h"
#include "extensions/postgres/server_sql.h"
#include "extensions/postgres/server_table.h"

namespace alidade::test {

using namespace database;

namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  for (const char character : text) bytes.push_back(static_cast<std::byte>(character));
  return bytes;
}

constexpr std::string_view k_head{"PGCOPY\n\377\r\n\0\0\0\0\0\0\0\0\0", 19};
/// Two values: 258, and none.
constexpr std::string_view k_row{"\0\2\0\0\0\2\1\2\377\377\377\377", 12};
constexpr std::string_view k_tail{"\377\377", 2};

std::string all_of(std::initializer_list<std::string_view> parts) {
  std::string text;
  for (const std::string_view part : parts) text += part;
  return text;
}

std::string error_of(const std::string& text) {
  CopyDecoder decoder(2, [](std::span<const CopyField>) {});
  try {
    decoder.add(bytes_of(text));
    decoder.finish();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(CopyDecoder, rows_are_read_wherever_they_are_cut) {
  const Bytes all = bytes_of(all_of({k_head, k_row, k_row, k_tail}));
  for (std::size_t step = 1; step <= all.size(); ++step) {
    int rows = 0;
    const NumberColumn number{.name = "n", .type = ScalarType::int16};
    CopyDecoder decoder(2, [&](std::span<const CopyField> fields) {
      ++rows;
      EXPECT_EQ(whole_of(number, fields[0]), 258);
      EXPECT_TRUE(fields[1].empty());
    });
    for (std::size_t at = 0; at < all.size(); at += step)
      decoder.add(std::span(all).subspan(at, std::min(step, all.size() - at)));
    decoder.finish();
    EXPECT_EQ(rows, 2) << step;
  }
}

TEST(CopyDecoder, what_is_no_rows_is_rejected) {
  const std::string whole = all_of({k_head, k_row, k_tail});
  EXPECT_EQ(error_of(whole), "");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(error_of(whole.substr(0, size)), "") << size;
  EXPECT_NE(error_of(whole + "x"), "");
  EXPECT_NE(error_of("PGCOPX" + whole.substr(6)), "");
  const auto changed = [&](std::size_t offset, char character) {
    std::string text = whole;
    text[offset] = character;
    return error_of(text);
  };
  EXPECT_NE(changed(14, 1).find("flags"), std::string::npos);
  EXPECT_NE(changed(18, 1).find("flags"), std::string::npos);
  EXPECT_NE(changed(20, 3).find("2 values"), std::string::npos);
  EXPECT_NE(changed(19, '\200'), "");
  EXPECT_NE(changed(24, 9).find("9 bytes"), std::string::npos);
  EXPECT_NE(changed(21, 0x7f), "");
  EXPECT_NE(changed(30, '\376'), "");
}

TEST(CloudValues, columns_become_attributes_and_dimensions) {
  const auto column = [](const char* name, ScalarType type) {
    return NumberColumn{.name = name, .type = type, .can_be_null = true};
  };
  ServerTable table;
  // Intensities that are not integers, and two colours of three, do not become attributes.
  for (const char* const name : {"x", "y", "z", "gps_time", "intensity"})
    table.columns.push_back(column(name, ScalarType::float64));
  for (const char* const name : {"id", "red", "green", "classification"})
    table.columns.push_back(column(name, ScalarType::int16));
  std::vector<ValueColumn> columns = value_columns(table, true);
  EXPECT_EQ(columns.size(), 5u);
  EXPECT_EQ(attributes_of(columns),
            Attribute::gps_time | Attribute::classification | Attribute::extra_dimensions);
  EXPECT_EQ(value_columns(table, false).size(), 6u);
  EXPECT_EQ(kept_columns(columns, Attribute::gps_time).size(), 1u);

  PointCloud cloud;
  CloudValues values(cloud, columns);
  append_rows(cloud, attributes_of(columns), 2);
  values.find_columns();
  const Bytes real = bytes_of({"\100\0\0\0\0\0\0\0", 8}), whole = bytes_of({"\0\3", 2}),
              large = bytes_of({"\1\0", 2});
  const auto location = [] { return std::string("row 7"); };
  const CopyField row[] = {real, real, whole, whole, whole}, none[5] = {};
  values.put(0, row, location);
  values.put(1, none, location);
  EXPECT_EQ(cloud.gps_times[0], 2.0);
  EXPECT_TRUE(std::isnan(cloud.gps_times[1]));
  EXPECT_EQ(cloud.classifications, (std::vector<std::uint8_t>{3, 0}));
  EXPECT_EQ(values.null_count(), 1u);
  ASSERT_EQ(cloud.extra_dimensions.size(), 3u);
  EXPECT_EQ(cloud.extra_dimensions[1].name, "red");
  EXPECT_EQ(cloud.extra_dimensions[1].values, (std::vector<std::uint8_t>{3, 0, 0, 0x80}));
  EXPECT_EQ(cloud.extra_dimensions[1].no_data,
            (std::array<std::uint8_t, 8>{0, 0x80, 255, 255, 255, 255, 255, 255}));

  const auto error_of_row = [&](std::span<const CopyField> fields) {
    try {
      values.put(0, fields, location);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const CopyField beyond[] = {real, real, whole, whole, large}, other[] = {whole, real, whole, whole, whole};
  EXPECT_NE(error_of_row(beyond).find(
                "classification out of range for the attribute; expected 0 to 255, found 256"),
            std::string::npos)
      << error_of_row(beyond);
  EXPECT_NE(error_of_row(other).find("the server sent a value of the wrong size for gps_time"),
            std::string::npos);
}

TEST(CloudValues, returns_keep_their_meaning_under_the_name_of_earlier_versions) {
  ServerTable table;
  for (const char* const name : {"x", "y", "z", "return_number", "return_count"})
    table.columns.push_back({.name = name, .type = ScalarType::int16});
  EXPECT_EQ(attributes_of(value_columns(table, true)), AttributeSet(Attribute::returns));
  table.columns.push_back({.name = "number_of_returns", .type = ScalarType::int16});
  const std::vector<ValueColumn> columns = value_columns(table, true);
  ASSERT_EQ(columns.size(), 3u);
  EXPECT_EQ(columns[1].attribute, std::nullopt);
  EXPECT_EQ(columns[2].attribute, Attribute::returns);
  EXPECT_EQ(columns[2].part, 1u);
}

TEST(FilterCondition, limits_are_widened_and_infinite_ones_left_out) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(filter_condition({}), "false");
  std::vector<PointFilter> filters(1);
  EXPECT_EQ(filter_condition(filters), "true");
  filters[0].lines.push_back({make_ray({1, 2, 3}, {0, 0, 1}), {0.0, 1.0}, {0.5, k_infinity}});
  const std::string text = filter_condition(filters);
  EXPECT_TRUE(
      text.starts_with("(dist_ray('1'::float8,'2'::float8,'3'::float8,'0'::float8,'0'::float8,'1'::float8,"
                       "x,y,z) <= '1.000000002"))
      << text;
  EXPECT_NE(text.find(" AND dist_plane("), std::string::npos);
  EXPECT_NE(text.find("x,y,z) >= '0.499999998"), std::string::npos) << text;
  filters.push_back({.box = Bounds()});
  EXPECT_EQ(filter_condition(filters), text + " OR (false AND false AND false)");
  for (const Interval& never :
       {Interval{std::nan(""), 1.0}, Interval{k_infinity, k_infinity}, Interval{2.0, 1.0}}) {
    filters.assign(1, {});
    filters[0].planes.push_back({make_plane({0, 0, 0}, {0, 0, 1}), never});
    EXPECT_EQ(filter_condition(filters), "(false)");
  }
}

TEST(CloudRow, texts_cannot_leave_their_quotes) {
  CloudRow row;
  row.crs.wkt = "it's";
  row.crs.geotiff_ascii = "a'|";
  EXPECT_NE(cloud_row_insert("\"t\"", row)
                .find("NULL, NULL, NULL, 'it''s', '\\x'::bytea, '\\x'::bytea, '\\x61277c'::bytea, false)"),
            std::string::npos)
      << cloud_row_insert("\"t\"", row);
  // Not UTF-8, not its shortest form, with a NUL, or one half of a surrogate pair of UTF-16.
  for (const std::string& wkt : {std::string("\377"), std::string("\300\257"), std::string("a\0b", 3),
                                 std::string("\355\240\200"), std::string("\303")}) {
    row.crs.wkt = wkt;
    EXPECT_NE(cloud_row_insert("\"t\"", row).find("NULL, NULL, NULL, '\\x'::bytea"), std::string::npos);
  }
}

}  // namespace
}  // namespace alidade::test
