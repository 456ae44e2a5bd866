// SPDX-License-Identifier: MIT
#include "tests/tools/cases.h"

namespace alidade::test {
namespace {

std::vector<Case> text_cases() {
  const std::string points = "SELECT x, y, z FROM points ORDER BY id";
  return {
      {"F_cc_header_and_count.asc",
       {sql("@F_cc_header_and_count.asc",
            "SELECT x, y, z, classification, intensity / 257 AS i, return_number, gps_time FROM points ORDER "
            "BY id")},
       {"x,y,z,classification,i,return_number,gps_time\n1.0,2.0,3.0,2,120,1,1000.5\n2.0,3.0,4.0,5,90,1,1000."
        "6\n5.0,6.0,7.0,2,80,2,1000.7\n"},
       {"unnamed columns"}},
      {"T10c_cr.txt", {sql("@T10c_cr.txt", points)}, {"x,y,z\n1.0,2.0,3.0\n4.0,5.0,6.0\n7.0,8.0,9.0\n"}, {}},
      {"T10b_utf16.csv",
       {{{"info", "@T10b_utf16.csv"}}},
       {"T10b_utf16.csv: text in UTF-16; expected UTF-8"},
       {},
       2},
      {"T11b_nan.csv",
       {sql("@T11b_nan.csv", "SELECT x, y, z, intensity / 257 AS i FROM points ORDER BY id")},
       {"x,y,z,i\n1.0,2.0,3.0,4\n5.0,6.0,7.0,0\n", "1 points without finite coordinates were skipped",
        "1 values of the column \"i\" are missing"},
       {}},
      {"T19_nil.csv",
       {sql("@T19_nil.csv", "SELECT x, y, z, c FROM points ORDER BY id")},
       {"x,y,z,c\n1.0,2.0,3.0,\n4.0,5.0,6.0,42.0\n", "1 values of the column \"i\" are missing"},
       {}},
      {"T6_deccomma_semicolon.csv",
       {sql("@T6_deccomma_semicolon.csv", points)},
       {"x,y,z\n691000.123,5336000.456,500.1\n691001.123,5336001.456,500.2\n"},
       {}},
      {"T17_units.csv",
       {sql("@T17_units.csv", "SELECT x, y, z, \"reflectance [dB]\" AS r FROM points ORDER BY id")},
       {"x,y,z,r\n1.0,2.0,3.0,-5.5\n4.0,5.0,6.0,-7.5\n"},
       {}},
      {"T17_units.csv with --columns",
       {{{"info", "@T17_units.csv", "--stats", "--columns", "x [ft],y [ft],z [ft],range"}}},
       {"x, y ft; z ft", "range", "--columns replaces the titles"},
       {}},
      {"Q1_names.csv",
       {sql("@Q1_names.csv", "SELECT t, dist, dx, rank FROM points ORDER BY id LIMIT 1")},
       {"t,dist,dx,rank\n100.0,0.5,0.1,1.0\n"},
       {}},
      {"Q1_names.csv with --where",
       {{{"info", "@Q1_names.csv", "--where", "t > 150"}}},
       {"points      2\n"},
       {}},
  };
}

std::vector<Case> cloud_cases() {
  const std::string heights = "SELECT id, height FROM points WHERE id BETWEEN 4 AND 6 ORDER BY id";
  const std::string no_height = "id,height\n4,0.04\n5,\n6,0.06\n";
  return {
      {"pcl_tutorial_ascii_rgb.pcd",
       {sql("@pcl_tutorial_ascii_rgb.pcd",
            "SELECT DISTINCT red / 257 AS r, green / 257 AS g, blue / 257 AS b FROM points")},
       {"128,128,224\n", "146,186,128\n"},
       {"64,64,112", "73,93,64"}},
      {"P4b_textmode.pcd",
       {{{"info", "@P4b_textmode.pcd"}}},
       {"the binary data were changed by a transfer as text"},
       {},
       2},
      {"Y14_ccnames.ply",
       {{{"convert", "@Y14_ccnames.ply", "-o", "names.las"}}},
       {"warning", "LAS keeps 32 bytes",
        "'scalar_C2C_absolute_distances[<5]_(Z)' becomes 'scalar_C2C_absolute_distances[_4'"},
       {}},
      {"Y14_ccnames.ply converted",
       {{{"convert", "@Y14_ccnames.ply", "-o", "names.las"}}, {{"info", "names.las"}}},
       {"extra       scalar_C2C_absolute_distances[<5, scalar_C2C_absolute_distances[_2, "
        "scalar_C2C_absolute_distances[_3, "
        "scalar_C2C_absolute_distances[_4\n"},
       {}},
      {"Y7_splat.ply",
       {{{"info", "@Y7_splat.ply"}}},
       {"attributes  color", "opacity, scales and rotations are not used"},
       {"f_dc_0"}},
      {"Y12_utmfloat.ply", {{{"info", "@Y12_utmfloat.ply"}}}, {"y in steps of 0.5", " 0.25 "}, {}},
      {"L10_nodata.las", {sql("@L10_nodata.las", heights)}, {no_height}, {}},
      {"L10_nodata.las as CSV",
       {{{"convert", "@L10_nodata.las", "-o", "n.csv"}}, sql("n.csv", heights)},
       {no_height},
       {}},
      {"L10_nodata.las as PLY",
       {{{"convert", "@L10_nodata.las", "-o", "n.ply"}}, sql("n.ply", heights)},
       {no_height},
       {}},
      {"L10_nodata.las as LAZ",
       {{{"convert", "@L10_nodata.las", "-o", "n.laz"}}, sql("n.laz", heights)},
       {no_height},
       {}},
      {"L10_nodata.las in statistics",
       {{{"info", "@L10_nodata.las", "--stats"}}},
       {"1 without value"},
       {"-327"}},
      {"L10_nodata.las in colours",
       {{{"render", "@L10_nodata.las", "--color-by", "height", "--size", "32x24", "--samples", "1", "-o",
          "n.png"}}},
       {"wrote n.png"},
       {"-327"}},
      {"L7b_evlr_start0.las",
       {{{"info", "@L7b_evlr_start0.las"}}},
       {"--partial reads the intact part"},
       {},
       2},
      {"L7b_evlr_start0.las with --partial",
       {{{"info", "@L7b_evlr_start0.las", "--partial"}}},
       {"points      400\n", "records are skipped"},
       {"lost"}},
      {"L7e_evlr_before_points.las with --partial",
       {{{"info", "@L7e_evlr_before_points.las", "--partial"}}},
       {"points      400\n", "records are skipped"},
       {"lost"}},
  };
}

std::vector<Case> camera_cases() {
  const Words render = {"render", "wall.xyz", "--size",         "32x24",       "--samples",
                        "1",      "-o",       "photo_%04d.png", "--overwrite", "--camera"};
  std::vector<Case> cases = {
      {"colmap_no_blank", {{with(render, {"@colmap_no_blank"})}}, {"photo_0001.png"}, {}}};
  for (const auto& [file, program] : {std::pair{"cameras.xml", "Metashape"},
                                      {"gs_cameras.json", "3D Gaussian Splatting"},
                                      {"gs_obj.json", "3D Gaussian Splatting"},
                                      {"o3d.json", "Open3D"},
                                      {"bundle.out", "Bundler"},
                                      {"model.nvm", "VisualSFM"},
                                      {"pix4d_calibrated_external_camera_parameters.txt", "Pix4D"},
                                      {"rc.csv", "RealityCapture"},
                                      {"traj_ypr.csv", "yaw, pitch and roll"}})
    cases.push_back(
        {file, {{with(render, {std::string("@cameras_other/") + file})}}, {program, "; expected "}, {}, 2});
  return cases;
}

std::vector<Case> answer_cases() {
  // Points of the faces of a tilted cube that look at the eye, by their planes.
  const std::string faces =
      "WITH planes AS (SELECT visible, 0.7559716855415145*x - 0.3963489711079061*y + 0.52097437917927*z AS a,"
      " 0.6283760266347787*x + 0.21635987791692637*y - 0.7472161483656925*z AS b,"
      " 0.18344039852286906*x + 0.8922420615110539*y + 0.4126181332179616*z AS c FROM points)"
      " SELECT count(*), round(100.0 * sum(visible) / count(*), 1) AS percent FROM planes WHERE a > (SELECT "
      "max(a) "
      "FROM planes) - 1e-6"
      " OR b > (SELECT max(b) FROM planes) - 1e-6 OR c > (SELECT max(c) FROM planes) - 1e-6";
  return {
      {"F_exact_plane_25.xyz",
       {{{"visibility", "points", "@F_exact_plane_25.xyz", "--observer=-24.8328,2,17.4164", "-o",
          "seen.las"}}},
       {"25 of 25 points are visible"},
       {}},
      {"F_cube_double.ply",
       {{{"visibility", "points", "@F_cube_double.ply", "--observer", "131.3,214.2,53.7", "-o", "seen.las"}},
        sql("seen.las", faces)},
       {"count(*),percent\n9962,99.8\n"},
       {}},
      {"vertical_feet_bmx-2010.las, sky",
       {{{"visibility", "sky", "@vertical_feet_bmx-2010.las", "-o", "sky.tif"}}},
       {"mean 0.99"},
       {}},
      {"vertical_feet_bmx-2010.las, viewshed",
       {{{"visibility", "raster", "@vertical_feet_bmx-2010.las", "--observer", "194490,259240",
          "--resolution", "1", "-o", "seen.tif"}}},
       {"visible 86.9 %"},
       {}},
      {"L13_a.las and L13_b.las",
       {{{"info", "@L13_a.las", "@L13_b.las"}}},
       {"points      400\n", "scale                    0.001              0.001              0.001\n"},
       {}},
      {"Z1_scan2d_a.pcd and Z1_scan2d_b.pcd",
       {{{"convert", "@Z1_scan2d_a.pcd", "-o", "a.las"}},
        {{"convert", "@Z1_scan2d_b.pcd", "-o", "b.las"}},
        {{"info", "a.las", "b.las"}}},
       {"points      720\n"},
       {"e-45"}},
  };
}

TEST_F(CasesTest, inputs_that_gave_wrong_answers_in_silence_give_the_right_ones) {
  std::vector<Case> all = text_cases();
  for (const std::vector<Case>& more : {cloud_cases(), camera_cases(), answer_cases()})
    all.insert(all.end(), more.begin(), more.end());
  const auto cases = shared_data("../cases");
  if (!cases)
    GTEST_SKIP() << all.size() << " cases were skipped: ../shared/cases beside the repository is not there";
  // What the two photos of the COLMAP model show.
  std::string wall;
  for (int i = 0; i < 441; ++i)
    wall += "110 " + std::to_string(190 + i % 21) + " " + std::to_string(i / 21) + "\n";
  write("wall.xyz", wall);
  for (const Case& each : all) check(each, *cases);
}

}  // namespace
}  // namespace alidade::test
