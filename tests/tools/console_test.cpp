// SPDX-License-Identifier: MIT
#include "tools/console.h"

#include "base/shown_text.h"
#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class ConsoleTest : public ProgramTest {};

TEST_F(ConsoleTest, names_of_files_do_not_move_the_cursor) {
  const ProgramResult result = run({"info", "no\x1b[2Jfile.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err.find('\x1b'), std::string::npos) << result.err;
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  cloud.extra_dimensions = {plain_dimension("he\x1b[5might", ScalarType::uint8)};
  cloud.extra_dimensions[0].values = {7};
  write_las(folder / "a\x1b[2J.las", cloud);
  const ProgramResult info = run({"info", "a\x1b[2J.las"});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_TRUE(contains(info.out, "he\\x1b[5might")) << info.out;
  EXPECT_EQ(info.out.find('\x1b'), std::string::npos) << info.out;
}

TEST_F(ConsoleTest, bytes_of_a_file_that_is_read_twice_are_counted_once) {
  write_square("square.xyz");
  const auto bytes = std::filesystem::file_size(folder / "square.xyz");
  const ProgramResult result = run({"convert", "square.xyz", "-o", "square.las"});
  EXPECT_TRUE(contains(result.err, "reading: " + quantity(static_cast<double>(bytes), "B") + " in"))
      << result.err;
}

TEST_F(ConsoleTest, copc_is_written_under_its_name) {
  write_square("square.xyz");
  for (const char* const name : {"square.copc.laz", "SQUARE.COPC.LAZ"}) {
    const ProgramResult result = run({"convert", "square.xyz", "-o", name});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(run({"info", name}).out, "COPC 1.4, point format 6, 400 points"));
  }
  const ProgramResult result = run({"convert", "square.xyz", "-o", "square.copc.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, ": COPC is compressed; expected the extension .copc.laz")) << result.err;
}

}  // namespace
}  // namespace alidade::test
