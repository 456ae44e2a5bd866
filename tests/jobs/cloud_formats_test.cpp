// SPDX-License-Identifier: MIT
#include "jobs/cloud_formats.h"

#include <algorithm>
#include <string_view>

#include "cloud/cloud_reader.h"
#include "tests/jobs/query_job.h"

namespace alidade::test {
namespace {

/// Text behind a first line "# marked".
const CloudFormat k_marked{
    .name = "Marked text",
    .is_begun_by =
        [](std::span<const std::byte> start) {
          constexpr std::string_view k_mark = "# marked";
          return std::string_view(reinterpret_cast<const char*>(start.data()), start.size())
              .starts_with(k_mark);
        },
    .open = [](InputFile file, Damage damage) { return open_text(std::move(file), damage); }};

// Before other tests of this program use formats.
[[maybe_unused]] const bool is_added = (jobs::add_format({.facts = {}, .format = &k_marked}), true);

using CloudFormatsTest = QueryJob;

TEST_F(CloudFormatsTest, an_added_format_of_files_is_read_as_those_of_the_core) {
  std::ofstream(folder / "site.xyzt") << "# marked\n1 2 3\n4 5 6\n";
  const std::filesystem::path name = folder / "site.xyzt";
  const CloudInput cloud = resolve_clouds({&name, 1}, jobs::cloud_formats()).inputs.front();
  EXPECT_TRUE(cloud.is(k_marked));
  EXPECT_FALSE(jobs::is_in_database(cloud));
  EXPECT_FALSE(jobs::has_parts(cloud));
  EXPECT_EQ(jobs::server_of(name.string()), nullptr);
  EXPECT_TRUE(contains(query("site.xyzt", {"--box", "3,3,3,9,9,9"}), "0,0,1,4,5,6\n"));
}

}  // namespace
}  // namespace alidade::test
