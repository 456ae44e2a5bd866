// SPDX-License-Identifier: MIT
// Mistakes of newcomers, and what the program replies: what was found, what was expected and what to type.
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

struct Mistake {
  Words words;
  std::vector<std::string> replies;  ///< all are in the message
};

const std::vector<Mistake> k_mistakes = {
    {{"render"}, {"nothing to render", "expected SCENE.json, CLOUD..., --mesh FILE or --site courtya"}},
    {{"render", "nothere.las", "-o", "a.png"},
     {"nothere.las: cannot open the file: No such file or directory"}},
    {{"render", "empty.las", "-o", "a.png"},
     {"empty.las: empty file", "expected LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an i"}},
    {{"render", "rand.las", "-o", "a.png"},
     {"rand.las: unknown format", "expected LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an i"}},
    {{"render", "text.txt", "-o", "a.png"},
     {"text.txt:line 1: neither a point nor a header with column names",
      "expected numbers, or column names with x, y and z"}},
    {{"render", "pic.png", "-o", "a.png"},
     {"pic.png: unknown format", "expected LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an i"}},
    {{"render", "dir", "-o", "a.png"},
     {"dir: the folder contains no cloud files",
      "expected the extension .las, .laz, .ply, .pcd, .e57, .pts, ."}},
    {{"render", "no*.las", "-o", "a.png"},
     {"no*.las: no matching cloud file", "expected a file, a folder, or a pattern"}},
    {{"render", "broken.json", "-o", "a.png"},
     {"broken.json:1:2: invalid JSON: unexpected end of input", "expected string literal"}},
    {{"render", "scene.json"}, {"scene.json: missing output", "expected -o FILE"}},
    {{"render", "c.las"}, {"missing output", "expected -o FILE"}},
    {{"render", "c.las", "-o", "a.gif"},
     {"a.gif: unknown output format", "expected the extension .exr, .png, .jpg, .jpeg or .tif"}},
    {{"render", "c.las", "-o", "a"},
     {"a: unknown output format", "expected the extension .exr, .png, .jpg, .jpeg or .tif"}},
    {{"render", "c.las", "-o", "nofolder/a.png"},
     {"nofolder/a.png: cannot write the file: no such folder nofolder"}},
    {{"render", "c.las", "-o", "pic.png"},
     {"pic.png: the file exists", "expected another name, or --overwrite"}},
    {{"render", "c.las", "-o", "c.las"},
     {"c.las: unknown output format", "expected the extension .exr, .png, .jpg, .jpeg or .tif"}},
    {{"render", "c.las", "-o", "dir"},
     {"dir: unknown output format", "expected the extension .exr, .png, .jpg, .jpeg or .tif"}},
    {{"render", "c.las", "--size", "600", "-o", "a.png"},
     {"--size: invalid value", "expected WIDTHxHEIGHT in pixels, such as 600x400"}},
    {{"render", "c.las", "--size", "0x5", "-o", "a.png"},
     {"--size: invalid value", "expected an integer from 1 to 65536"}},
    {{"render", "c.las", "--samples", "none", "-o", "a.png"},
     {"--samples: invalid value", "expected a number"}},
    {{"render", "c.las", "--radius", "-1", "-o", "a.png"},
     {"--radius: invalid value", "expected auto, adapted or a positive length"}},
    {{"render", "c.las", "--camera", "nothere.json", "-o", "a.png"}, {"nothere.json: no such file"}},
    {{"render", "c.las", "--camera", "t.csv", "-o", "a.png"},
     {"t.csv:line 1: missing column 'time'", "expected a header with time,x,y,z,qw,qx,qy,qz or x,y,z,look_"}},
    {{"render", "c.las", "--camera", "c.las", "-o", "a.png"},
     {"c.las:line 1: missing column 'time'", "expected a header with time,x,y,z,qw,qx,qy,qz or x,y,z,look_"}},
    {{"render", "c.las", "--colour-by", "height", "-o", "a.png"},
     {"unknown option '--colour-by'; did you mean '--color-by'?"}},
    {{"render", "c.las", "--color-by", "hight", "-o", "a.png"},
     {"c.las: the cloud has no attribute \"hight\", did you mean \"height\"?",
      "expected one of height, normal, rgb, intensity, classificati"}},
    {{"render", "c.las", "--color-by", "near_infrared", "-o", "a.png"},
     {"c.las: the cloud has no attribute \"near_infrared\"",
      "expected one of height, normal, rgb, intensity, classificati"}},
    {{"render", "c.las", "--mode", "pathtrace", "-o", "a.png"},
     {"--mode: invalid value", "expected path|ambient_occlusion|headlight|flat"}},
    {{"render", "c.las", "--orthographic", "-o", "a.tif"}, {"--orthographic: invalid value", "expected top"}},
    {{"render", "c.las", "--orthographic", "top", "-o", "a.tif"}, {"--orthographic requires --resolution"}},
    {{"render", "c.las", "--orthographic", "top", "--resolution", "0.1", "--extent", "0,0,1", "-o", "a.tif"},
     {"--extent: invalid value", "expected 4 numbers separated by commas"}},
    {{"render", "c.las", "--panorama", "1,2", "-o", "a.png"},
     {"--panorama: invalid value", "expected 3 numbers separated by commas"}},
    {{"render", "c.las", "--sun", "300", "-o", "a.png"},
     {"--sun: invalid value", "expected two numbers separated by a comma"}},
    {{"render", "c.las", "--layers", "depth", "-o", "a.png"},
     {"a.png: layers require EXR", "expected the extension .exr, or no --layers"}},
    {{"render", "c.las", "scene.json", "-o", "a.png"},
     {"invalid operands", "expected one scene file, or clouds"}},
    {{"render", "c.las", "--mesh", "c.las", "-o", "a.png", "--dry-run"},
     {"c.las: unknown mesh format", "expected the extension .ply or .obj"}},
    {{"render", "c.las", "--orbit", "-o", "a.png"},
     {"a.png: 150 cameras, but one output name (--camera-name selects one camera)",
      "expected one %04d (number), %s or %f (name) in the output na"}},
    {{"render", "c.las", "-o", "a.mp4"},
     {"a.mp4: a video requires a flight", "expected --orbit, or --keyframes FILE"}},
    {{"renderr", "c.las", "-o", "a.png"}, {"unknown command 'renderr'; did you mean 'render'?"}},
    {{"render", "c.las", "--outptu", "a.png"}, {"unknown option '--outptu'; did you mean '--output'?"}},
    {{"render", "c.las", "-o"}, {"--output: missing value", "expected --output FILE"}},
    {{"render", "c.las", "--exposure", "bright", "-o", "a.png"},
     {"--exposure: invalid value", "expected a number of stops or auto"}},
    {{"render", "cut.las", "-o", "a.png"},
     {"cut.las:byte 247: truncated file: it ends before its last point",
      "expected 2000 points of 36 bytes at byte 1026"}},
    {{"info"}, {"missing FILE...", "expected alidade info [OPTIONS] FILE..."}},
    {{"info", "nothere.las"}, {"nothere.las: cannot open the file: No such file or directory"}},
    {{"info", "c.las", "--jsn"}, {"unknown option '--jsn'; did you mean '--json'?"}},
    {{"info", "c.las", "--where", "class = 2"},
     {"c.las: invalid condition 'class = 2': no such column: class",
      "expected a condition on x, y, z, red, green, blue, intensity"}},
    {{"info", "c.las", "--where", "classification == "},
     {"--where: invalid condition 'classification == ': incomplete input",
      "expected a condition such as \"classification = 2 AND intensi"}},
    {{"info", "c.las", "--classes", "ground"}, {"--classes: invalid value", "expected a number"}},
    {{"info", "c.las", "--classes", "300"},
     {"--classes: invalid value", "expected an integer from 0 to 255"}},
    {{"info", "c.las", "--crop", "1,2,3"},
     {"--crop: invalid value", "expected x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a polygon file"}},
    {{"info", "c.las", "--crop", "5,5,1,1"}, {"--crop: limits out of order", "expected the lower x first"}},
    {{"info", "c.las", "--crop", "nothere.geojson"},
     {"nothere.geojson: not a file", "expected x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a polygon file"}},
    {{"info", "c.las", "--crop", "0,0,1,1"},
     {"c.las: no points are selected", "expected a selection that some points meet"}},
    {{"info", "c.las", "--crs", "EPSG:0"},
     {"unknown reference system", "expected a reference system such as EPSG:25832"}},
    {{"info", "c.las", "--crs", "28992"}, {"unknown reference system", "expected EPSG:28992, found '28992'"}},
    {{"info", "c.las", "--reproject", "utm32"},
     {"unknown reference system", "expected a reference system such as EPSG:25832"}},
    {{"info", "t.csv", "--reproject", "EPSG:25832"},
     {"t.csv: cannot reproject: the reference system is unknown", "expected --crs EPSG:n, which states it"}},
    {{"info", "c.las", "--verify"},
     {"c.las: no checksums to verify", "expected an index file (alidade index)"}},
    {{"convert", "c.las"},
     {"missing --output FILE.las|.laz|.copc.laz|.ply|.csv|.xyz|.alidade",
      "expected alidade convert [OPTIONS] FILE..."}},
    {{"convert", "c.las", "-o", "a.txt"},
     {"a.txt: unknown output format", "expected the extension .las, .laz, .copc.laz, .ply, .csv, .xyz"}},
    {{"convert", "c.las", "-o", "a.copc.las"},
     {"a.copc.las: COPC is compressed", "expected the extension .copc.laz"}},
    {{"convert", "c.las", "-o", "a.e57"},
     {"a.e57: unknown output format", "expected the extension .las, .laz, .copc.laz, .ply, .csv, .xyz"}},
    {{"convert", "-o", "a.las"}, {"missing FILE...", "expected alidade convert [OPTIONS] FILE..."}},
    {{"convert", "c.las", "-o", "exists.las"},
     {"exists.las: the file exists", "expected another name, or --overwrite"}},
    {{"convert", "c.las", "-o", "a.las", "--spacing", "0"},
     {"--spacing: invalid value", "expected a positive length"}},
    {{"convert", "c.las", "-o", "a.las", "--every", "0"},
     {"--every: invalid value", "expected an integer from 1 to 18446744073709551615"}},
    {{"convert", "c.las", "-o", "a.las", "--color-depth", "12"},
     {"--color-depth: invalid value", "expected 8|16"}},
    {{"convert", "c.las", "t.csv", "-o", "c.las"},
     {"c.las: the output is also an input", "expected another output name"}},
    {{"index", "c.las", "-o", "a.las"}, {"a.las: unknown output format", "expected the extension .alidade"}},
    {{"index", "c.las"}, {"missing --output FILE.alidade", "expected alidade index [OPTIONS] FILE..."}},
    {{"index", "c.las", "-o", "a.alidade", "--organisation", "tree"},
     {"--organisation: invalid value", "expected adaptive|fixed|layered"}},
    {{"query", "c.las"},
     {"missing targets", "expected one of --rays, --lines, --cones, --path, --planes, --boxes, "}},
    {{"query", "c.las", "--ray", "1,2,3"},
     {"--ray: \"1,2,3\": not a ray", "expected ox,oy,oz,dx,dy,dz[,t_min][,t_max]"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,0"},
     {"--ray: \"1,2,3,0,0,0\": direction of the ray is zero", "expected a nonzero direction"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,x"}, {"--ray: \"1,2,3,0,0,x\": invalid dz", "expected a number"}},
    {{"query", "c.las", "--rays", "nothere.csv"},
     {"nothere.csv: cannot open the file: No such file or directory"}},
    {{"query", "c.las", "--rays", "zero.csv"},
     {"zero.csv:2:7: direction of the ray is zero", "expected a nonzero direction"}},
    {{"query", "c.las", "--rays", "short.csv"},
     {"short.csv:1:15: missing column dz", "expected ox,oy,oz,dx,dy,dz[,t_min][,t_max]"}},
    {{"query", "c.las", "--rays", "text.txt"},
     {"text.txt:1:1: unknown column \"hello world\"",
      "expected one of ox, oy, oz, dx, dy, dz, t_min, t_max"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,1", "--radius", "-1"},
     {"--radius: invalid value", "expected a number, at least 0, or inf"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,1", "--k", "0"},
     {"--k: invalid value", "expected an integer from 1 to 18446744073709551615"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,1", "--t-min", "a"},
     {"--t-min: invalid value", "expected a number, inf or -inf"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,1", "--box", "0,0,0,1,1,1"},
     {"rays and boxes are different kinds of targets", "expected one kind per run"}},
    {{"query", "c.las", "--ray", "1,2,3,0,0,1", "-o", "a.png"},
     {"a.png: unknown output format", "expected the extension .csv, .jsonl, .las or .laz, or --form"}},
    {{"query", "c.alidade", "--ray", "1,2,3,0,0,1", "--max-level", "2", "--dry-run"},
     {"c.alidade: --max-level requires a layered index",
      "expected a layered index (alidade index --organisation layer"}},
    {{"query", "t.csv", "--ray", "1,2,3,0,0,1", "--classes", "2"},
     {"t.csv: --classes requires classification", "expected a classified cloud"}},
    {{"visibility"}, {"missing command", "expected one of points, raster, horizon, sky, sun, lines, su"}},
    {{"visibility", "rasta", "c.las"}, {"unknown command 'rasta'; did you mean 'raster'?"}},
    {{"visibility", "raster", "c.las", "-o", "a.tif"},
     {"missing observers", "expected --observer, --observers or --observer-grid"}},
    {{"visibility", "raster", "c.las", "--observer", "690000", "-o", "a.tif"},
     {"--observer 690000: invalid position", "expected X,Y,Z, or X,Y for a position on the ground"}},
    {{"visibility", "raster", "c.las", "--observer", "48.05,11.5", "-o", "a.tif"},
     {"--observer 48.05,11.5: the observer is 5369440 outside of the cloud",
      "expected coordinates of the cloud, or --observers-crs EPSG:4"}},
    {{"visibility", "raster", "c.las", "--observer", "5325000,690000", "-o", "a.tif"},
     {"--observer 5325000,690000: the observer is 6554801 outside of the cloud",
      "expected x before y: the coordinates seem to be exchanged; -"}},
    {{"visibility", "raster", "c.las", "--observer", "690000,5325000", "-o", "a.png"},
     {"a.png: unknown output format", "expected the extension .tif"}},
    {{"visibility", "raster", "c.las", "--observers", "semi.csv", "-o", "a.tif"},
     {"semi.csv:line 1: unknown column \"heigth\"",
      "expected x,y[,z][,name][,height][,azimuth_min][,azimuth_max]"}},
    {{"visibility", "raster", "c.las", "--observers", "dec.csv", "-o", "a.tif"},
     {"dec.csv:line 2: too many columns", "expected 2, separated by commas as in the header"}},
    {{"visibility", "raster", "c.las", "--observers", "lonlat.csv", "-o", "a.tif"},
     {"lonlat.csv:line 1: unknown column \"lon\"",
      "expected x,y[,z][,name][,height][,azimuth_min][,azimuth_max]"}},
    {{"visibility", "raster", "c.las", "--observers", "nocol.csv", "-o", "a.tif"},
     {"nocol.csv:line 1: unknown column \"e\"",
      "expected x,y[,z][,name][,height][,azimuth_min][,azimuth_max]"}},
    {{"visibility", "raster", "c.las", "--observers", "text.txt", "-o", "a.tif"},
     {"text.txt:line 1: unknown column \"hello world\"",
      "expected x,y[,z][,name][,height][,azimuth_min][,azimuth_max]"}},
    {{"visibility", "points", "c.las", "--observer", "690000,5325000,602"},
     {"missing --output FILE.las|FILE.laz|FILE.ply",
      "expected alidade visibility points [OPTIONS] CLOUD..."}},
    {{"visibility", "points", "c.las", "--observer", "690000,5325000,602", "-o", "a.tif"},
     {"a.tif: unknown output format", "expected the extension .las, .laz or .ply"}},
    {{"visibility", "sun", "c.las", "-o", "a.las"},
     {"missing --from DATE", "expected alidade visibility sun [OPTIONS] CLOUD..."}},
    {{"visibility", "sun", "c.las", "--from", "2026-13-01", "-o", "a.las"},
     {"--from: invalid date", "expected a date such as 2026-06-21"}},
    {{"visibility", "sun", "c.las", "--from", "yesterday", "-o", "a.las"},
     {"--from: invalid date and time", "expected one like \"2003-10-17T12:30:30-07:00\" or \"2003-10-17"}},
    {{"visibility", "horizon", "c.las", "-o", "a.csv"},
     {"missing observers", "expected --observer, --observers or --observer-grid"}},
    {{"visibility", "lines", "c.las", "--pairs", "nothere.csv", "-o", "a.csv"},
     {"nothere.csv: cannot open the file: No such file or directory"}},
    {{"compare", "pic.png"}, {"nothing to compare", "expected REFERENCE and TEST, or --pairs FILE.csv"}},
    {{"compare", "pic.png", "nothere.png"}, {"nothere.png: no such file"}},
    {{"compare", "pic.png", "c.las"},
     {"c.las: cannot read the image: OpenImageIO could not find a format reader for \"c.las\". Is i"}},
    {{"compare", "pic.png", "pic.png", "--fail-above", "flp=0.1"},
     {"--fail-above: unknown metric 'flp' in a threshold",
      "expected one of flip, flip_median, flip_q1, flip_q3, flip_ma", "did you mean"}},
    {{"sql"},
     {"missing cloud or database", "expected alidade sql CLOUD \"SELECT ...\", or alidade sql load"}},
    {{"sql", "nothere.db", "SELECT 1"}, {"nothere.db: unable to open database file"}},
    {{"sql", "c.txt", "SELECT 1"}, {"c.txt: cannot open the file"}},
    {{"sql", "c.db", "SELEC 1"},
     {"statement:1:1: the statement is not read-only", "expected SELECT, WITH, VALUES or EXPLAIN"}},
    {{"sql", "c.db", "SELECT foo FROM points"},
     {"statement:1:8: no such column: foo; expected one of id, x, y, z, "}},
    {{"sql", "load", "c.las"}, {"too few operands", "expected FILE... DB"}},
    {{"sql", "load", "c.las", "a.las"},
     {"a.las: the database name is that of a cloud file",
      "expected the database as the last name, such as site.db"}},
    {{"generate", "castle", "-o", "a.las"}, {"site: invalid value", "expected courtyard"}},
    {{"generate", "courtyard", "-o", "a.las", "--points", "0"},
     {"--points: invalid value", "expected an integer from 1 to 4294967295"}},
    {{"generate", "courtyard", "--points", "10", "-o", "a.xyz"},
     {"a.xyz: unknown output format", "expected the extension .las or .laz"}},
    {{"merge", "a", "b", "-o", "c.png"}, {"a: cannot open the file: No such file or directory"}},
    {{"help", "rendr"}, {"unknown command 'rendr'; did you mean 'render'?"}},
    {{"help", "viewshed"}, {"unknown command 'viewshed'; did you mean 'visibility viewshed'?"}},
    {{"horizon", "c.las"}, {"unknown command 'horizon'; did you mean 'visibility horizon'?"}},
    {{"manual"}, {"missing FOLDER", "expected alidade manual [OPTIONS] FOLDER"}},
};

/// The folder of a newcomer's first hour.
class MistakesTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const auto make = [&](const Words& words) { ASSERT_EQ(run(words).exit_code, 0); };
    make({"generate", "courtyard", "--points", "2000", "-o", "c.las", "-q"});
    make({"convert", "c.las", "-o", "c.ply", "-q"});
    make({"index", "c.las", "-o", "c.alidade", "-q"});
    make({"sql", "load", "c.las", "c.db", "-q"});
    make({"render", "c.las", "-o", "pic.png", "--size", "16x16", "--samples", "1", "-q"});
    write("t.csv", "x,y,z\n1,2,3\n");
    write("semi.csv", "x;y;heigth\n690000;5325000;1.7\n");
    write("dec.csv", "x,y\n690000,5;5325000,5\n");
    write("lonlat.csv", "lon,lat\n11.5,48.05\n");
    write("nocol.csv", "name,e\na,1\n");
    write("zero.csv", "ox,oy,oz,dx,dy,dz\n1,2,3,0,0,0\n");
    write("short.csv", "ox,oy,oz,dx,dy\n1,2,3,0,0\n");
    write("empty.las", "");
    write("rand.las", std::string("\x01\x02\xff\xfe\x00\x80 no cloud \x90", 16));
    write("text.txt", "hello world, no cloud\n");
    write("scene.json", R"({"version":1})");
    write("broken.json", "{");
    write("exists.las", "precious");
    write("cut.las", read("c.las").substr(0, 20000));
    std::filesystem::create_directories(folder / "dir");
  }

  /// Every `step`-th mistake, so that several processes share the work.
  void expect_replies(std::size_t first, std::size_t step) {
    for (std::size_t i = first; i < k_mistakes.size(); i += step) {
      const Mistake& mistake = k_mistakes[i];
      std::string said;
      for (const std::string& word : mistake.words) said += " " + word;
      const auto before = names();
      const ProgramResult result = run(mistake.words);
      EXPECT_EQ(result.exit_code, 2) << "alidade" << said;
      for (const std::string& reply : mistake.replies)
        EXPECT_TRUE(contains(result.err, reply)) << "alidade" << said << "\n"
                                                 << result.err << "lacks: " << reply;
      EXPECT_EQ(names(), before) << "alidade" << said;
    }
    EXPECT_EQ(read("exists.las"), "precious");
  }
};

TEST(MistakesTableTest, there_are_at_least_ninety) {
  EXPECT_GE(k_mistakes.size(), 90u);
}

TEST_F(MistakesTest, are_explained_first_third) {
  expect_replies(0, 3);
}

TEST_F(MistakesTest, are_explained_second_third) {
  expect_replies(1, 3);
}

TEST_F(MistakesTest, are_explained_last_third) {
  expect_replies(2, 3);
}

}  // namespace
}  // namespace alidade::test
