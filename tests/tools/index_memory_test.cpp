// SPDX-License-Identifier: MIT
// Index files of clouds that memory need not hold.
#include <fmt/format.h>

#include <random>

#include "tests/tools/run_program.h"
#include "tools/command.h"

namespace alidade::test {
namespace {

class IndexMemoryTest : public ProgramTest {
 protected:
  void make_site() {
    ASSERT_EQ(run({"generate", "courtyard", "--points", "200000", "-o", "site.las", "-q"}).exit_code, 0);
  }

  std::string index(const std::string& name, Words words) {
    words.insert(words.begin(), "index");
    words.insert(words.end(), {"-q", "-o", name});
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read(name);
  }

  void expect_same_bytes(const Words& words) {
    const std::string whole = index("whole.alidade", words);
    Words small = words;
    small.insert(small.end(), {"--memory", "1M"});
    EXPECT_TRUE(whole == index("pieces.alidade", small));
    std::filesystem::remove(folder / "whole.alidade");
    std::filesystem::remove(folder / "pieces.alidade");
  }
};

TEST_F(IndexMemoryTest, has_the_bytes_of_the_index_made_in_memory) {
  make_site();
  write("plain.xyz", "690002 5325000.25 601\n690003 5325000.5 602\n");
  write("colored.csv",
        "x,y,z,red,green,blue,height\n690000,5325000,600,1,2,3,0.5\n690001,5325000,600,7,8,9,1.5\n");
  expect_same_bytes({"site.las"});
  // Columns that come late and others that end early; 8-bit colours that turn out to be so at the end.
  expect_same_bytes({"colored.csv", "site.las", "plain.xyz"});
  expect_same_bytes({"plain.xyz", "colored.csv"});
  expect_same_bytes({"site.las", "--crop", "690000,5325000,690010,5325010"});
  for (const char* const organisation : {"fixed", "layered"})
    expect_same_bytes({"site.las", "--organisation", organisation});
  expect_same_bytes({"site.las", "--spacings", "4"});
  expect_same_bytes({"site.las", "--attributes", "gps_time,color"});
}

TEST_F(IndexMemoryTest, has_the_same_surfaces) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.las", "-q"}).exit_code, 0);
  expect_same_bytes({"site.las", "--surfaces"});
}

TEST_F(IndexMemoryTest, is_asked_by_more_threads_than_cores_if_memory_does_not_hold_it) {
  write("big.alidade", std::string(1000, ' '));
  const std::string file = (folder / "big.alidade").string();
  const Words render = {"alidade", "render", file, "-o", "picture.png"};
  EXPECT_GE(tools::enough_threads(render, 999), 8);
  EXPECT_FALSE(tools::enough_threads(render, 1000));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "convert", file}, 999));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "render", file + ".las"}, 999));
}

TEST_F(IndexMemoryTest, holds_clouds_that_are_sparse_for_their_lattice) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> position(0.0, 1e6);
  std::string text;
  for (int i = 0; i < 150'000; ++i)
    text += fmt::format("{:.3f} {:.3f} {:.3f}\n", position(random), position(random), position(random));
  write("sparse.xyz", text);
  expect_same_bytes({"sparse.xyz"});
}

TEST_F(IndexMemoryTest, keeps_all_points_of_repeated_tiles_and_warns) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2000", "-o", "a.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"convert", "a.las", "-o", "a.laz", "-q"}).exit_code, 0);
  expect_same_bytes({"a.las", "a.laz", "a.las"});
  const ProgramResult same = run({"index", "a.las", "a.las", "-o", "b.alidade", "--memory", "1M"});
  EXPECT_NE(same.err.find("a.las: given more than once; its points are repeated"), std::string::npos)
      << same.err;
  EXPECT_NE(same.err.find("4000 points"), std::string::npos) << same.err;
  const ProgramResult copy = run({"index", "a.las", "a.laz", "-o", "c.alidade", "--memory", "1M"});
  EXPECT_NE(copy.err.find("a.laz: as many points within the same bounds as a.las"), std::string::npos)
      << copy.err;
}

TEST_F(IndexMemoryTest, states_what_the_disk_has_to_hold) {
  make_site();
  const ProgramResult result = run({"index", "site.las", "-o", "site.alidade", "--memory", "1M"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("up to 13.4 MB of temporary files in ., where"), std::string::npos) << result.err;
  EXPECT_EQ(names(), (Words{"site.alidade", "site.las"}));
}

TEST_F(IndexMemoryTest, leaves_nothing_on_a_full_disk) {
  make_site();
  // The first cannot hold the points in Morton order, the second the index.
  for (const std::uint64_t size : {std::uint64_t{1} << 20, std::uint64_t{5} << 20}) {
    const ProgramResult result =
        run_on_full_disk({"index", "site.las", "-o", "site.alidade", "--memory", "1M", "-q"}, size);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err.find("alidade: error: "), 0u) << result.err;
    EXPECT_EQ(names(), (Words{"site.las"}));
  }
}

TEST_F(IndexMemoryTest, rejects_what_needs_memory) {
  make_site();
  const ProgramResult result =
      run({"index", "site.las", "-o", "site.alidade", "--memory", "1M", "--stored-order"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("--memory excludes"), std::string::npos) << result.err;
  EXPECT_EQ(run({"index", "site.las", "-o", "site.alidade", "--memory", "1k"}).exit_code, 2);
}

}  // namespace
}  // namespace alidade::test
