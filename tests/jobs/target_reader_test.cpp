// SPDX-License-Identifier: MIT
#include "jobs/query/targets.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/input_file.h"
#include "base/progress.h"

namespace alidade::test {

namespace {

class TargetReaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("alidade_targets_" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(file_); }

  static jobs::CheckedQuery query(jobs::TargetFamily family, jobs::GivenTargets given) {
    jobs::CheckedQuery query;
    query.family = family;
    query.given(family) = std::move(given);
    return query;
  }

  /// A text of so many rows, all of the same length.
  jobs::GivenTargets rows(const std::string& header, const std::string& row, int count) {
    std::ofstream stream(file_);
    stream << header;
    for (int i = 0; i < count; ++i) stream << row;
    stream.close();
    return {.text = file_.string()};
  }

  std::filesystem::path file_;
};

TEST_F(TargetReaderTest, share_follows_the_targets_given_out_in_small_texts_and_large_ones) {
  for (const int count : {1000, 500000}) {
    const jobs::CheckedQuery given = query(jobs::TargetFamily::points, rows("x,y,z\n", "1,2,3\n", count));
    jobs::TargetReader<glm::dvec3> reader(given);
    jobs::TargetBatch<glm::dvec3> batch;
    for (int part = 1; part <= 10; ++part) {
      ASSERT_TRUE(reader.next(static_cast<std::size_t>(count / 10), batch));
      EXPECT_NEAR(reader.share(), part / 10.0, 1e-3) << count;
    }
    EXPECT_FALSE(reader.next(1, batch));
    EXPECT_EQ(reader.share(), 1.0);
  }
}

TEST_F(TargetReaderTest, share_of_regions_follows_their_planes) {
  std::string text;
  for (int region = 10; region < 20; ++region) {
    for (int plane = 0; plane < 6; ++plane) text += "1,2,3,0,0,1," + std::to_string(region) + "\n";
  }
  const jobs::CheckedQuery given =
      query(jobs::TargetFamily::planes, rows("px,py,pz,nx,ny,nz,region\n", text, 1));
  jobs::TargetReader<HalfSpaces> reader(given);
  jobs::TargetBatch<HalfSpaces> batch;
  ASSERT_TRUE(reader.next(5, batch));
  EXPECT_EQ(batch.targets.size(), 5u);
  // The plane that ended the fifth region is read.
  EXPECT_NEAR(reader.share(), 31.0 / 60.0, 0.02);
}

TEST_F(TargetReaderTest, share_is_not_known_of_what_is_no_file) {
  const jobs::CheckedQuery given = query(jobs::TargetFamily::points, {.values = {"1,2,3", "4,5,6"}});
  jobs::TargetReader<glm::dvec3> reader(given);
  jobs::TargetBatch<glm::dvec3> batch;
  ASSERT_TRUE(reader.next(1, batch));
  EXPECT_EQ(reader.share(), 0.0);
}

TEST_F(TargetReaderTest, numbers_are_read_like_texts_and_their_share_is_known) {
  std::vector<double> rows;
  for (int i = 0; i < 50000; ++i) rows.insert(rows.end(), {1.0 * i, 0.5, -2.0});
  const jobs::CheckedQuery given = query(jobs::TargetFamily::points, {.rows = rows});
  jobs::TargetReader<glm::dvec3> reader(given);
  jobs::TargetBatch<glm::dvec3> batch;
  for (int part = 0; part < 5; ++part) {
    ASSERT_TRUE(reader.next(10000, batch));
    ASSERT_EQ(batch.targets.size(), 10000u);
    EXPECT_EQ(batch.ids.back(), 10000u * static_cast<unsigned>(part) + 9999u);
    EXPECT_EQ(batch.targets.back(), glm::dvec3(10000.0 * part + 9999.0, 0.5, -2.0));
    EXPECT_NEAR(reader.share(), 0.2 * (part + 1), 1e-12);
  }
  EXPECT_FALSE(reader.next(1, batch));
}

TEST_F(TargetReaderTest, pipes_and_standard_input_are_read_once) {
  EXPECT_TRUE(rows("x,y,z\n", "1,2,3\n", 1).can_be_reread());
  EXPECT_TRUE((jobs::GivenTargets{.values = {"1,2,3"}}).can_be_reread());
  std::filesystem::remove(file_);
  EXPECT_TRUE(
      (jobs::GivenTargets{.text = file_.string()}).can_be_reread());  // an error as often as it is read
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  const jobs::CheckedQuery piped = query(jobs::TargetFamily::points, {.text = file_.string()});
  EXPECT_FALSE(piped.given_targets().can_be_reread());
  // Nothing comes, and no signal reaches this thread.
  const FileDescriptor writer(file_.string(), O_RDWR);
  int questions = 0;
  EXPECT_THROW(jobs::TargetReader<glm::dvec3>(piped, [&] { return ++questions > 1; }), Cancelled);
  // Even beside a file of this name.
  const std::filesystem::path before = std::filesystem::current_path();
  const std::filesystem::path folder = file_.string() + ".folder";
  std::filesystem::create_directories(folder);
  std::filesystem::current_path(folder);
  std::ofstream("-") << "x,y,z\n1,2,3\n";
  EXPECT_FALSE((jobs::GivenTargets{.text = "-"}).can_be_reread());
  std::filesystem::current_path(before);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace alidade::test
