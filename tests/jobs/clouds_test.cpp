// SPDX-License-Identifier: MIT
// Jobs on files of clouds: generate, info, index, convert and catalog.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "cloud/las/write_las.h"
#include "jobs/clouds/catalog.h"
#include "jobs/clouds/convert.h"
#include "jobs/clouds/index.h"
#include "jobs/clouds/info.h"
#include "simulation/scan.h"
#include "tests/jobs/cloud_folder.h"
#include "tests/support/garden.h"

namespace alidade::test {
namespace {

using Json = nlohmann::ordered_json;

class CloudJobsTest : public CloudFolderTest {};

TEST_F(CloudJobsTest, a_scan_is_a_file_or_a_cloud) {
  scan("site.las", 3000);
  const PointCloud file = read_cloud(folder / "site.las");
  jobs::GenerateRequest wanted;
  wanted.point_count = 3000;
  const PointCloud cloud = run(plan(wanted), heard);
  EXPECT_EQ(cloud.size(), 3000u);
  EXPECT_EQ(cloud.lattice, file.lattice);
  EXPECT_EQ(cloud.positions, file.positions);
  EXPECT_EQ(cloud.colors, file.colors);
  EXPECT_EQ(cloud.gps_times, file.gps_times);
  EXPECT_EQ(cloud.attributes(), simulation::scan_attributes());
  EXPECT_EQ(cloud.crs.wkt, file.crs.wkt);
}

TEST_F(CloudJobsTest, plans_check_outputs_before_points_are_read) {
  write_las(folder / "garden.las", garden(k_metres));
  jobs::GenerateRequest scan;
  scan.output = folder / "scan.ply";
  EXPECT_THROW(plan(scan), Error);
  EXPECT_THROW(plan(request<jobs::IndexRequest>({"garden.las"}, "garden.las")), Error);
  EXPECT_THROW(plan(request<jobs::ConvertRequest>({"garden.las"}, "garden.doc")), Error);
  EXPECT_THROW(plan(request<jobs::ConvertRequest>({"garden.las"}, "garden.las")), Error);
  EXPECT_THROW(plan(request<jobs::CatalogRequest>({"garden.las"}, "garden.json")), Error);
  auto kept = request<jobs::IndexRequest>({"garden.las"}, "garden.alidade");
  kept.checkpoint.file = folder / "kept";
  EXPECT_THROW(plan(kept), Error) << "without memory to sort in";
  EXPECT_TRUE(heard.text().empty()) << heard.text();
}

TEST_F(CloudJobsTest, unknown_formats_name_those_that_are_known) {
  const auto problem_of = [&](const auto& wanted) -> std::string {
    try {
      plan(wanted);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  write("a.xyz", "0 0 0\n");
  EXPECT_NE(problem_of(request<jobs::ConvertRequest>({"a.xyz"}, "b.las.txt"))
                .find("b.las.txt: unknown output format; expected the extension .las, .laz, .copc.laz, .ply, "
                      ".csv, .xyz or .alidade"),
            std::string::npos);
  EXPECT_NE(problem_of(request<jobs::IndexRequest>({"a.xyz"}, "b"))
                .find("b: unknown output format; expected the extension .alidade"),
            std::string::npos);
  EXPECT_NE(problem_of(request<jobs::IndexRequest>({"a.xyz"}, ".alidade")).find("unknown output format"),
            std::string::npos);
  EXPECT_EQ(problem_of(request<jobs::ConvertRequest>({"a.xyz"}, "B.LAZ")), "");
}

TEST_F(CloudJobsTest, information_has_no_points) {
  scan("site.las", 2000);
  const jobs::InfoResult info = run(plan(request<jobs::InfoRequest>({"site.las"})), heard);
  EXPECT_EQ(info.point_count, 2000u);
  EXPECT_EQ(info.facts.size(), 0u);
  EXPECT_TRUE(info.facts.attributes().bits == 0);
  EXPECT_TRUE(info.attributes.contains(Attribute::color));
  ASSERT_EQ(info.file_bounds.size(), 1u);
  EXPECT_EQ(info.file_bounds[0].min, info.bounds.min);
  EXPECT_EQ(info.file_bounds[0].max, info.bounds.max);
  EXPECT_EQ(info.plane_unit, "m");
}

TEST_F(CloudJobsTest, an_index_has_counts_and_sizes) {
  scan("site.las", 60'000);
  auto wanted = request<jobs::IndexRequest>({"site.las"}, "whole.alidade");
  wanted.contents.spacing_neighbours = 4;
  const jobs::IndexResult whole = run(plan(wanted), heard);
  EXPECT_EQ(whole.point_count, 60'000u);
  EXPECT_EQ(whole.bytes, std::filesystem::file_size(folder / "whole.alidade"));
  EXPECT_LT(whole.octree_bytes, whole.bytes);
  EXPECT_EQ(heard.stages,
            (std::vector<std::string>{"scanning", "reading", "building", "measuring spacings", "writing"}));
  wanted.output = folder / "large.alidade";
  wanted.memory = std::size_t{1} << 20;
  EXPECT_THROW(run(plan(wanted), heard), Error) << "without the extension scratch";
}

TEST_F(CloudJobsTest, a_converted_cloud_has_counts_and_bounds) {
  scan("site.las", 2000);
  auto wanted = request<jobs::ConvertRequest>({"site.las"}, "site.laz");
  const jobs::ConvertResult packed = run(plan(wanted), heard);
  EXPECT_EQ(packed.point_count, 2000u);
  EXPECT_EQ(packed.input_count, 2000u);
  EXPECT_FALSE(packed.bounds);
  wanted = request<jobs::ConvertRequest>({"site.las"}, "some.ply");
  wanted.every = 3;
  const jobs::ConvertResult some = run(plan(wanted), heard);
  EXPECT_EQ(some.point_count, 667u);
  EXPECT_EQ(some.input_count, 2000u);
  ASSERT_TRUE(some.bounds);
  const Bounds written = read_cloud(folder / "some.ply").bounds();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(some.bounds->min[axis], written.min[axis], 1e-6);
    EXPECT_NEAR(some.bounds->max[axis], written.max[axis], 1e-6);
  }
  EXPECT_EQ(heard.notes.back(), "wrote 667 of 2000 points to " + (folder / "some.ply").string());
}

TEST_F(CloudJobsTest, a_catalog_has_a_row_per_file) {
  scan("site.las", 2000);
  write("plain.xyz", "690002 5325000.25 601\n690003 5325000.5 602\n");
  const auto wanted = request<jobs::CatalogRequest>({"site.las", "plain.xyz"}, "all.catalog.json");
  const jobs::CatalogResult catalog = run(plan(wanted), heard);
  ASSERT_EQ(catalog.files.size(), 2u);
  EXPECT_EQ(catalog.files[0].name, "site.las");
  EXPECT_EQ(catalog.files[0].format, "LAS");
  EXPECT_EQ(catalog.files[0].point_count, 2000u);
  EXPECT_EQ(catalog.files[0].modified.size(), std::string("2026-05-01T12:00:00Z").size());
  EXPECT_EQ(catalog.files[1].point_count, 2u);
  EXPECT_FALSE(catalog.systems.at(catalog.files[0].system).empty());
  EXPECT_TRUE(catalog.systems.at(catalog.files[1].system).empty());
  EXPECT_EQ(heard.warnings.back(),
            "1 of 2 files state no reference system; they have no position on the globe");
  EXPECT_EQ(files({"all.catalog.json"}).size(), 2u);
}

}  // namespace
}  // namespace alidade::test
