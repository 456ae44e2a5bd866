// SPDX-License-Identifier: MIT
#include <cmath>

#include "base/text_scanner.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

PointCloud read_text(std::string_view text) {
  return read_alone(open_text, text);
}

std::string text_error(std::string_view text) {
  return reading_error(open_text, text);
}

TEST(TextScanner, numbers_are_whole_words_in_any_notation) {
  EXPECT_EQ(parse_number("1.5"), 1.5);
  EXPECT_EQ(parse_number("+1.5"), 1.5);
  EXPECT_EQ(parse_number("-.5E-1"), -0.05);
  EXPECT_EQ(parse_number("1e999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("-1e999"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("0.5e400"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("1e-999"), 0.0);
  EXPECT_EQ(parse_number("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_TRUE(std::isnan(parse_number("NaN").value()));
  for (const char* word : {"", "+", "-", "+-1", "1,5", "1.5m", "0x10", "1 ", "1e", "--1"})
    EXPECT_FALSE(parse_number(word)) << word;
}

TEST(TextScanner, written_decimals_count_digits_after_the_point_and_the_exponent) {
  EXPECT_EQ(written_decimals("12"), 0);
  EXPECT_EQ(written_decimals("-1.250"), 3);
  EXPECT_EQ(written_decimals("1.25e-2"), 4);
  EXPECT_EQ(written_decimals("1.25E+01"), 1);
  EXPECT_EQ(written_decimals("1e3"), -3);
}

TEST(TextScanner, lines_with_any_line_end_with_and_without_mark_and_longer_than_the_window) {
  // 70000 lines of 16 bytes exceed the window of a mebibyte, and one of them straddles its end.
  std::string text =
      "\xEF\xBB\xBF"
      "first\r\n";
  for (int i = 0; i < 70000; ++i) text += "line " + std::to_string(100000 + i) + " ..\n";
  text += "last";
  InputFile file(std::as_bytes(std::span(text)), "memory");
  TextScanner scanner(file);
  EXPECT_EQ(scanner.next_line(), "first");
  for (int i = 0; i < 70000; ++i)
    ASSERT_EQ(scanner.next_line(), "line " + std::to_string(100000 + i) + " ..");
  EXPECT_EQ(scanner.next_line(), "last");
  EXPECT_EQ(scanner.line_number(), 70002u);
  EXPECT_EQ(scanner.offset(), text.size());
  EXPECT_EQ(scanner.next_line(), std::nullopt);
}

TEST(TextScanner, lines_end_with_line_feeds_carriage_returns_or_both) {
  const auto lines_of = [](const std::string& text) {
    InputFile file(std::as_bytes(std::span(text)), "memory");
    TextScanner scanner(file);
    std::vector<std::string> lines;
    while (const auto line = scanner.next_line()) lines.emplace_back(*line);
    EXPECT_EQ(scanner.line_number(), lines.size());
    EXPECT_EQ(scanner.offset(), text.size());
    return lines;
  };
  const std::vector<std::string> expected = {"a", "", "b c"};
  for (const char* text :
       {"a\n\nb c", "a\r\rb c", "a\r\n\r\nb c", "a\n\nb c\n", "a\r\rb c\r", "a\r\n\nb c\r\n", "a\n\rb c"})
    EXPECT_EQ(lines_of(text), expected) << text;
  // A window is a mebibyte and a little more. A carriage return may be its last byte, and its line feed the
  // first byte of the next window.
  for (const std::size_t before : {0u, 1u, 2u, 3u, 4u}) {
    const std::string first(before, 'f'), second((1 << 20) - 1, 'x');
    for (const char* end : {"\r\n", "\r", "\n"})
      EXPECT_EQ(lines_of(first + "\n" + second + end + "last"),
                (std::vector<std::string>{first, second, "last"}));
  }
  // Linear also without any line feed: this would take minutes otherwise.
  std::string many;
  for (int i = 0; i < 2'000'000; ++i) many += "1\r";
  EXPECT_EQ(lines_of(many).size(), 2'000'000u);
}

TEST(Text, any_separator_with_comments_and_empty_lines) {
  for (const char* text :
       {"1.5 2.5 3.5\n4.5 5.5 6.5\n", "# made\n\n  1.5\t2.5   3.5 \r\n// more\n4.5 5.5 6.5",
        "1.5,2.5,3.5\n4.5, 5.5, 6.5\n", "1.5;2.5;3.5;\n4.5;5.5;6.5;\n",
        "\xEF\xBB\xBF"
        "1.5 2.5 3.5\n   # remark\n4.5 5.5 6.5\n"}) {
    const PointCloud cloud = read_text(text);
    ASSERT_EQ(cloud.size(), 2u) << text;
    expect_near(cloud.world(0), {1.5, 2.5, 3.5}, 1e-12);
    expect_near(cloud.world(1), {4.5, 5.5, 6.5}, 1e-12);
    EXPECT_EQ(cloud.files[0].format, "XYZ");
    EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.1));
  }
}

TEST(Text, the_lattice_has_the_decimals_that_were_written) {
  const PointCloud cloud = read_text("690000.123 5325000.45 500\n690010.5 5325001 501\n");
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.001));
  EXPECT_EQ(to_lattice(cloud.lattice, {690000.123, 5325000.45, 500}), cloud.positions[0]);
  EXPECT_EQ(cloud.world(0).x, cloud.lattice.offset.x + 0.001 * cloud.positions[0].x);
  expect_near(cloud.world(0), {690000.123, 5325000.45, 500}, 1e-9);
}

TEST(Text, columns_without_names_go_by_number_and_content) {
  const auto names = [](const char* text) {
    const PointCloud cloud = read_text(text);
    for (const std::string& warning : cloud.warnings) {
      const std::string mark = "unnamed columns were read as ";
      if (const std::size_t offset = warning.find(mark); offset != warning.npos)
        return warning.substr(offset + mark.size());
    }
    return std::string("no warning");
  };
  EXPECT_EQ(names("1 2 3\n"), "no warning");
  EXPECT_EQ(names("1 2 3 0.5\n"), "x y z intensity");
  EXPECT_EQ(names("1 2 3 4 5\n"), "x y z column_4 column_5");
  EXPECT_EQ(names("1 2 3 255 0 128\n"), "x y z red green blue");
  EXPECT_EQ(names("1 2 3 0.1 0 0.9\n"), "x y z red green blue");
  EXPECT_EQ(names("1 2 3 0 0.6 -0.8\n"), "x y z normal_x normal_y normal_z");
  EXPECT_EQ(names("1 2 3 0 6.5 -0.8\n"), "x y z column_4 column_5 column_6");
  EXPECT_EQ(names("1 2 3 -100 255 0 128\n"), "x y z intensity red green blue");
  EXPECT_EQ(names("1 2 3 255 0 128 0.25\n"), "x y z red green blue intensity");
  EXPECT_EQ(names("1 2 3 100 0 0.6 -0.8\n"), "x y z intensity normal_x normal_y normal_z");
  EXPECT_EQ(names("1 2 3 0 0.6 -0.8 1.5\n"), "x y z normal_x normal_y normal_z intensity");
  EXPECT_EQ(names("1 2 3 255 0 128 0 0.6 -0.8\n"), "x y z red green blue normal_x normal_y normal_z");
  EXPECT_EQ(names("1 2 3 0 0.6 -0.8 255 0 128\n"), "x y z normal_x normal_y normal_z red green blue");
  EXPECT_EQ(names("1 2 3 77 255 0 128 0 0.6 -0.8\n"),
            "x y z intensity red green blue normal_x normal_y normal_z");
}

TEST(Text, csv_columns_go_by_their_names) {
  const PointCloud cloud = read_text(
      "\"Point "
      "Id\",Northing,\"Easting\",Elevation,R,G,B,Intensity,Classification,gps_time,NX,NY,NZ,Amplitude,"
      "Remark\n"
      "17,5325000.25,690000.5,500.125,255,128,0,40000,6,1234.5,0,0,1,0.25,\"gate, left\"\n"
      "18,5325001.25,690001.5,501.125,0,0,1,65535,2,1235.5,1,0,0,,none\n");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.files[0].format, "CSV");
  expect_near(cloud.world(0), {690000.5, 5325000.25, 500.125}, 1e-9);
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.001));
  EXPECT_EQ(cloud.colors[0], Color16(65535, 128 * 257, 0));
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{40000, 65535}));
  EXPECT_EQ(cloud.classifications, (std::vector<std::uint8_t>{6, 2}));
  EXPECT_EQ(cloud.gps_times, (std::vector<double>{1234.5, 1235.5}));
  EXPECT_EQ(cloud.normals[1], glm::vec3(1, 0, 0));
  EXPECT_EQ(extra_value<double>(cloud, "Point Id", 1), 18.0);
  EXPECT_EQ(extra_value<double>(cloud, "Amplitude", 0), 0.25);
  EXPECT_TRUE(std::isnan(extra_value<double>(cloud, "Amplitude", 1)));
  EXPECT_EQ(cloud.extra_dimensions.size(), 2u);
  EXPECT_TRUE(warns(cloud, "\"Remark\" contains no numbers"));
}

TEST(Text, names_may_be_separated_by_blanks_tabs_or_be_in_a_comment) {
  const PointCloud blanks = read_text("X Y Z Amplitude\n1 2 3 4\n");
  EXPECT_EQ(extra_value<double>(blanks, "Amplitude", 0), 4.0);
  EXPECT_EQ(blanks.files[0].format, "XYZ");
  const PointCloud tabs = read_text("Point Id\tx\ty\tz\n7\t1\t2\t3\n");
  EXPECT_EQ(extra_value<double>(tabs, "Point Id", 0), 7.0);
  const PointCloud comment = read_text("//X Y Z Height_above_ground\n1 2 3 4\n");
  EXPECT_EQ(extra_value<double>(comment, "Height_above_ground", 0), 4.0);
  const PointCloud no_names = read_text("# one scan taken today\n1 2 3 4\n");
  EXPECT_EQ(no_names.intensities.size(), 1u);
}

/// The cloud that CloudCompare's export of three points is, with titles, count line, or both.
void expect_named_points(const std::string& text) {
  const PointCloud cloud = read_text(text);
  ASSERT_EQ(cloud.size(), 3u) << text;
  expect_near(cloud.world(0), {1, 2, 3}, 1e-9);
  expect_near(cloud.world(2), {5, 6, 7}, 1e-9);
  EXPECT_EQ(cloud.classifications, (std::vector<std::uint8_t>{2, 5, 2})) << text;
  EXPECT_EQ(cloud.gps_times, (std::vector<double>{1000.5, 1000.75, 1001})) << text;
  EXPECT_TRUE(cloud.colors.empty()) << text;
}

TEST(Text, titles_hold_with_and_without_a_count_line_in_any_order_of_columns) {
  const std::string rows = "1.0 2.0 3.0 2 1000.5\n2.0 3.0 4.0 5 1000.75\n5.0 6.0 7.0 2 1001\n";
  const std::string turned = "2.0 1.0 3.0 1000.5 2\n3.0 2.0 4.0 1000.75 5\n6.0 5.0 7.0 1001 2\n";
  const auto with = [](std::string text, char separator) {
    std::ranges::replace(text, ' ', separator);
    return text;
  };
  for (const std::string before : {"", "3\n", "# made by hand\n"}) {
    for (const std::string after : {"", "3\n"}) {
      if (before == after && !before.empty()) continue;
      for (const std::string mark : {"//", "", "# "}) {
        for (const char separator : {' ', ';', ',', '\t'}) {
          expect_named_points(before + mark + with("X Y Z Classification GpsTime\n", separator) + after +
                              with(rows, separator));
          expect_named_points(before + mark + with("Y X Z Gps_Time Scalar_Classification\n", separator) +
                              after + with(turned, separator));
        }
      }
    }
  }
  // A comment that names other columns than there are is none of titles.
  EXPECT_TRUE(warns(read_text("//X Y Z\n1 2 3 4\n"), "unnamed columns were read as x y z intensity"));
}

TEST(Text, decimal_commas_are_read_where_no_comma_separates) {
  for (const char* text : {"X;Y;Z;I\n691000,125;5336000,25;500,5;10\n691001;5336001;501;20\n",
                           "X\tY\tZ\tI\n691000,125\t5336000,25\t500,5\t10\n691001\t5336001\t501\t20\n",
                           "691000,125;5336000,25;500,5;10\n691001;5336001;501;20\n",
                           "691000,125 5336000,25 500,5 10\n691001 5336001 501 20\n",
                           "2\n691000,125 5336000,25 500,5 10\n691001 5336001 501 20\n"}) {
    const PointCloud cloud = read_text(text);
    ASSERT_EQ(cloud.size(), 2u) << text;
    expect_near(cloud.world(0), {691000.125, 5336000.25, 500.5}, 1e-9);
    EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.001));
  }
  EXPECT_EQ(read_text("1,2 3,4 5,6\n").world(0), glm::dvec3(1.2, 3.4, 5.6));
  // Commas beside blanks separate.
  for (const char* text : {"1, 2, 3\n", "1 ,2 ,3\n", "1 , 2 , 3\n"})
    EXPECT_EQ(read_text(text).world(0), glm::dvec3(1, 2, 3)) << text;
  // What could be thousands is no decimal comma.
  EXPECT_NE(text_error("x;y;z\n1,5;2,5;3,5\n1.5;2;3\n")
                .find("line 3: invalid value in the column \"x\"; expected a decimal comma"),
            std::string::npos);
  EXPECT_NE(text_error("x,y,z\n\"1,234\",2,3\n").find("line 2: invalid value in the column \"x\""),
            std::string::npos);
}

TEST(Text, missing_values_are_none_and_points_without_coordinates_are_left_out) {
  const PointCloud cloud = read_text(
      "x,y,z,i,range,gps_time\n1,2,3,1000,7.5,10\n,,,,,\n5,6,7,,nil,NA\n8,9,10,null,-,\n11,,12,1,1,1\n13,14,"
      "none,1,1,1\n");
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.files[0].dropped_count, 3u);
  EXPECT_TRUE(warns(cloud, "3 points without finite coordinates were skipped"));
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{1000, 0, 0}));
  EXPECT_TRUE(warns(cloud, "2 values of the column \"i\" are missing and were read as 0"));
  EXPECT_EQ(extra_value<double>(cloud, "range", 0), 7.5);
  for (const std::size_t point : {1u, 2u}) {
    EXPECT_TRUE(std::isnan(extra_value<double>(cloud, "range", point)));
    EXPECT_TRUE(std::isnan(cloud.gps_times[point]));
  }
  EXPECT_FALSE(warns(cloud, "invalid numbers"));
  // The first row may be the one with a gap, and a column may have values only later.
  const PointCloud gaps = read_text("x,y,z,a\n-,2,3,\n1,2,3,\n4,5,6,\n");
  EXPECT_EQ(gaps.size(), 2u);
  EXPECT_EQ(gaps.extra_dimensions.size(), 1u);
  EXPECT_EQ(read_text("1,2,nan,4\n1,2,3,nil\n").size(), 1u);
}

TEST(Text, units_in_brackets_count) {
  const auto crs_of = [](const std::string& text) {
    InputFile file(std::as_bytes(std::span(text)), "memory");
    return open_text(std::move(file))->facts().crs.wkt;
  };
  const PointCloud metres = read_text("x [m],y [m],z (Metres),reflectance [dB]\n1,2,3,-5.5\n4,5,6,-7.5\n");
  EXPECT_EQ(metres.world(1), glm::dvec3(4, 5, 6));
  EXPECT_EQ(extra_value<double>(metres, "reflectance [dB]", 1), -7.5);
  EXPECT_EQ(crs_of("x [m],y [m],z [m]\n1,2,3\n"), "");
  EXPECT_EQ(crs_of("x,y,z\n1,2,3\n"), "");
  EXPECT_NE(crs_of("x [ft],y [ft],z [ft]\n1,2,3\n").find("LOCAL_CS[\"unknown, in ft\""), std::string::npos);
  EXPECT_NE(crs_of("x [ft],y [ft],z\n1,2,3\n").find("UNIT[\"foot\",0.3048]"), std::string::npos);
  EXPECT_NE(crs_of("Easting (US ft);Northing (US ft);Z\n1;2;3\n").find("US survey foot"), std::string::npos);
  const std::string mixed = crs_of("x [m],y [m],z [us-ft]\n1,2,3\n");
  EXPECT_TRUE(mixed.starts_with("COMPD_CS[")) << mixed;
  EXPECT_NE(mixed.find("LOCAL_CS[\"unknown, in m\""), std::string::npos);
  EXPECT_NE(mixed.find("VERT_CS[\"unknown, in US ft\""), std::string::npos);
  EXPECT_TRUE(
      warns(read_text("lon [deg],lat [deg],z [m]\n8,50,100\n"), "degrees of an unknown reference system"));
  EXPECT_TRUE(warns(read_text("lon [deg],lat [deg],z [us-ft]\n8,50,100\n"),
                    "z is in US ft, which --vertical-unit states"));
  EXPECT_NE(text_error("x [furlong],y [furlong],z\n1,2,3\n")
                .find("unknown unit of the column \"x [furlong]\"; expected m, ft or US ft"),
            std::string::npos);
  EXPECT_NE(text_error("x [m],y [ft],z\n1,2,3\n").find("x and y are in different units"), std::string::npos);

  const PointCloud others = read_text("x,y,z,time [ms],scan_angle [deg]\n1,2,3,1500,10\n");
  EXPECT_TRUE(others.gps_times.empty());
  EXPECT_EQ(extra_value<double>(others, "time [ms]", 0), 1500.0);
  EXPECT_TRUE(warns(others, "\"time [ms]\" is not in seconds"));
  EXPECT_EQ(others.scan_angles, std::vector<float>{10});
  EXPECT_EQ(read_text("x,y,z,time [s]\n1,2,3,1.5\n").gps_times, std::vector<double>{1.5});
  // What is in brackets without being a unit belongs to the name.
  EXPECT_EQ(extra_value<double>(read_text("x,y,z,C2C[<5]\n1,2,3,4\n"), "C2C[<5]", 0), 4.0);
}

TEST(Text, columns_without_titles_can_be_named) {
  const auto read = [](const std::string& text, const std::vector<std::string>& names) {
    InputFile file(std::as_bytes(std::span(text)), "memory");
    const auto reader = open_text(std::move(file), Damage::reject, names);
    const CoordinateSurvey survey = reader->survey({});
    PointCloud cloud;
    cloud.lattice = fit_lattice({&survey, 1});
    reader->read(cloud, AttributeSet::all(), {}, {});
    return cloud;
  };
  const std::vector<std::string> names = {"y", "x", "z", "gps_time", " echo"};
  for (const char* text : {"2 1 3 7 9\n", "2;1;3;7;9\n", "1\n2 1 3 7 9\n", "//a b c d e\n2 1 3 7 9\n",
                           "a,b,c,d,e\n2,1,3,7,9\n"}) {
    const PointCloud cloud = read(text, names);
    ASSERT_EQ(cloud.size(), 1u) << text;
    EXPECT_EQ(cloud.world(0), glm::dvec3(1, 2, 3));
    EXPECT_EQ(cloud.gps_times, std::vector<double>{7});
    EXPECT_EQ(extra_value<double>(cloud, "echo", 0), 9.0);
  }
  EXPECT_TRUE(warns(read("a,b,c,d,e\n2,1,3,7,9\n", names), "--columns replaces the titles \"a,b,c,d,e\""));
  EXPECT_NE(error_of([&] { read("1 2 3\n", names); }).find("expected 3 names, found 5"), std::string::npos);
  EXPECT_NE(error_of([&] {
              read("1 2 3\n", {"a", "b", "c"});
            }).find("--columns names no coordinates; expected x and y"),
            std::string::npos);
}

TEST(Text, other_encodings_than_utf_8_are_errors_that_say_so) {
  std::string little = "\xff\xfe", big = "\xfe\xff", bare;
  for (const char character : std::string("x,y,z\n1,2,3\n")) {
    little += {character, '\0'};
    big += {'\0', character};
    bare += {character, '\0'};
  }
  for (const std::string& text : {little, big, bare}) {
    EXPECT_NE(text_error(text).find("text in UTF-16; expected UTF-8 or ASCII"), std::string::npos)
        << text_error(text);
    const std::string message = error_of([&] { read_memory(std::as_bytes(std::span(text))); });
    EXPECT_NE(message.find("text in UTF-16"), std::string::npos) << message;
  }
  EXPECT_EQ(read_text("\xEF\xBB\xBFx,y,z\n1,2,3\n").size(), 1u);
}

TEST(Text, carriage_returns_end_lines) {
  EXPECT_EQ(read_text("1 2 3\r4 5 6\r7 8 9\r").size(), 3u);
  EXPECT_EQ(read_text("//X Y Z I\r2\r1 2 3 4\r4 5 6 7\r").size(), 2u);
  EXPECT_EQ(read_text("x,y,z\r\n1,2,3\r\n").size(), 1u);
}

TEST(Text, x_comes_before_other_names_for_the_same_axis) {
  const PointCloud cloud = read_text("height,easting,x,y,z\n9,8,1,2,3\n");
  EXPECT_EQ(cloud.world(0), glm::dvec3(1, 2, 3));
  EXPECT_EQ(extra_value<double>(cloud, "height", 0), 9.0);
  EXPECT_EQ(extra_value<double>(cloud, "easting", 0), 8.0);
}

TEST(Text, points_that_are_not_finite_are_dropped_and_counted) {
  const PointCloud cloud = read_text("x,y,z\n1,2,3\nnan,2,3\n1,inf,3\n1,2,1e999\n4,5,6\n");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.files[0].dropped_count, 3u);
}

TEST(Text, pts_in_several_blocks) {
  const PointCloud cloud = read_text("2\n1 2 3 -2048 255 0 1\n4 5 6 2047 0 0 0\n\n0\n1\n7 8 9 0 1 2 3\n");
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.files[0].format, "PTS");
  EXPECT_EQ(cloud.world(2), glm::dvec3(7, 8, 9));
  EXPECT_EQ(cloud.colors[0], Color16(65535, 0, 257));
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{0, 65535, 32776}));
  EXPECT_TRUE(warns(cloud, "intensities range from -2048 to 2047 because some are negative"));
}

TEST(Text, intensities_of_pts_from_0_to_255_fill_16_bits) {
  EXPECT_EQ(read_text("2\n1 2 3 0\n4 5 6 255\n").intensities, (std::vector<std::uint16_t>{0, 65535}));
}

TEST(Text, files_without_points_read) {
  for (const char* text : {"", "\n\n", "# nothing\n", "0\n", "0", "x,y,z\n"})
    EXPECT_EQ(read_text(text).size(), 0u) << text;
}

TEST(Text, errors_name_file_line_expectation_and_finding) {
  const auto expect = [](const std::string& text, const char* message) {
    EXPECT_NE(text_error(text).find(message), std::string::npos) << text_error(text) << "\nfor\n"
                                                                 << text.substr(0, 300);
  };
  expect("1 2 3\n4 five 6\n",
         "memory:line 2: invalid value in the column \"y\"; expected a number, found \"five\"");
  expect("1 2 3\n\n4 5\n", "memory:line 3: too few columns; expected 3, found 2");
  expect("1 2 3\n4 5 6 7\n", "memory:line 2: too many columns; expected 3, found 4");
  expect("1 2\n", "memory:line 1: too few columns for a point");
  expect("1,2,3,4\n1,2,3,four\n", "memory:line 2: invalid value in the column \"intensity\"");
  expect("hello world\n1 2 3\n", "memory:line 1: neither a point nor a header with column names");
  expect("X,Y,X\n1,2,3\n", "duplicate column name; expected unique names, found \"X\"");
  expect("x,z\n1,2\n", "memory:line 1: neither a point nor a header");
  expect("x,y,z,a\n1,2\n", "memory:line 2: too few columns");
  expect("3\n1 2 3\n4 5 6\n",
         "truncated file: too short for the points of the count line; expected at most 2, found 3");
  expect("3\n1.25 2.25 3.25\n4.25 5.25 6.25\n", "truncated file; expected 1 more points");
  expect("18446744073709551615\n1 2 3\n",
         "memory:line 1: truncated file: too short for the points of the count line");
  expect("1\n1 2 3\n4 5 6\n", "memory:line 3: more points than the count line states");
  expect("1\n1 2 3\n-4\n", "memory:line 3: more points than the count line states");
  expect(std::string(10 << 20, 'x'), "memory:line 1: line too long; expected at most 1048576 bytes");
  expect(std::string("\0\1\2", 3),
         "memory:line 1: neither a point nor a header with column names; expected numbers, or "
         "column names with x, y and z, also by --columns, found \"\\x00\\x01\\x02\"");
}

TEST(Text, more_than_4096_columns_are_an_error_of_their_line) {
  std::string names = "x,y,z", numbers = "1 2 3";
  for (int i = 4; i <= 4096; ++i) {
    names += ",c" + std::to_string(i);
    numbers += " 0.5";
  }
  for (const std::string& text : {names + "\n", numbers + "\n", "1\n" + numbers + "\n"})
    EXPECT_EQ(text_error(text), "");
  const std::string expected = "too many columns; expected at most 4096, found 4097";
  EXPECT_NE(text_error(names + ",last\n").find("memory:line 1: " + expected), std::string::npos);
  EXPECT_NE(text_error(numbers + " 7\n").find("memory:line 1: " + expected), std::string::npos);
  EXPECT_NE(text_error("1\n" + numbers + " 7\n").find("memory:line 2: " + expected), std::string::npos);
}

TEST(Text, every_truncation_is_an_error_or_a_clean_read) {
  const std::string pts = "2\n1.5 2 3 4 5 6 7\n1.5 2 3 4 5 6 7\n1\n1.5 2 3 4 5 6 7\n";
  const std::string csv = "x,y,z,\"a b\"\n1.5,2,3,4\n1.5,2,3,4\n";
  EXPECT_EQ(read_text(pts).size(), 3u);
  EXPECT_EQ(read_text(csv).size(), 2u);
  // After "", the first block, the second block's count line without its end, and the last number.
  EXPECT_LE(count_readable_prefixes(open_text, pts), 5u);
  // "", the header from its second name on, and rows whose last cell is not cut off but may be empty.
  EXPECT_EQ(count_readable_prefixes(open_text, csv), 16u);
}

TEST(Text, reads_files_of_other_programs) {
  const std::filesystem::path bunny_path = shared_data("text/bunnyData.pts");
  if (bunny_path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud bunny = read_alone(open_text, InputFile(bunny_path));
  ASSERT_EQ(bunny.size(), 30571u);
  EXPECT_EQ(bunny.files[0].format, "PTS");
  EXPECT_EQ(bunny.lattice.scale, glm::dvec3(1e-6));
  expect_near(bunny.world(0), {-0.037829, 0.12794, 0.004474}, 1e-15);
  expect_near(bunny.bounds().min, {-0.094689, 0.040011, -0.061873}, 1e-15);
  expect_near(bunny.bounds().max, {0.061009, 0.187321, 0.058799}, 1e-15);

  const PointCloud ripple = read_alone(open_text, InputFile(shared_data("text/ripple.pts")));
  ASSERT_EQ(ripple.size(), 10201u);
  EXPECT_EQ(ripple.files[0].format, "XYZ");
  expect_near(ripple.bounds().min, {-5, -5, -0.6664}, 1e-12);
  expect_near(ripple.bounds().max, {5, 5, 1.1}, 1e-12);
  glm::u64vec3 color_sum(0);
  for (const Color16& color : ripple.colors) color_sum += glm::u64vec3(color);
  EXPECT_EQ(color_sum, glm::u64vec3(302999, 1370248, 565336) * std::uint64_t{257});
  EXPECT_EQ(ripple.intensities.size(), ripple.size());
}

TEST(Text, a_header_that_names_a_column_twice_is_an_error) {
  const std::filesystem::path path = shared_data("malformed/badheader.txt");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const std::string message = error_of([&] { open_text(InputFile(path)); });
  EXPECT_NE(message.find("badheader.txt:line 1: duplicate column name"), std::string::npos) << message;
}

}  // namespace
}  // namespace alidade::test
