// SPDX-License-Identifier: MIT
#include "compare/report/page.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/output_file.h"
#include "compare/batch.h"
#include "compare/report/report_page.h"
#include "tests/compare/chromium.h"
#include "tests/compare/image_files.h"

// The pages as people use them, in a browser without a window.

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

namespace fs = std::filesystem;

constexpr const char* k_hostile =
    "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>";

class ReportTest : public ImageFilesTest {
 protected:
  void SetUp() override {
    ImageFilesTest::SetUp();
    if (!chromium_program()) GTEST_SKIP() << "pages are tested with chromium only (apt-get install chromium)";
  }

  /// Two images of 120 x 80 pixels: a wave, and the same with two bright squares.
  void write_images() {
    std::vector<float> wave(120 * 80 * 3);
    for (std::size_t i = 0; i < wave.size(); ++i)
      wave[i] = 0.4f + 0.2f * std::sin(0.05f * static_cast<float>(i / 3 % 120));
    write_image("wave.png", 120, 80, wave, {{"Comment", k_hostile}, {"alidade:samples", "16"}});
    paint(wave, {10, 10, 30, 25});
    paint(wave, {80, 50, 90, 60});
    write_image("<img src=x onerror=hacked()>'\".png", 120, 80, wave, {{"alidade:samples", "64"}});
  }
  static void paint(std::vector<float>& image, const image::PixelBox& box) {
    for (int y = box.top; y < box.bottom; ++y)
      for (int x = box.left; x < box.right; ++x)
        for (int c = 0; c < 3; ++c) image[static_cast<std::size_t>((y * 120 + x) * 3 + c)] = 1.0f;
  }

  fs::path write_report() {
    write_images();
    ComparisonOptions options;
    options.find_changes = ChangeMap::color;
    options.keep_images = true;
    const Comparison comparison =
        compare_files(folder / "wave.png", folder / "<img src=x onerror=hacked()>'\".png", options);
    const Verdict verdict = judge(comparison, parse_thresholds("flip=0.001,psnr<5"));
    write_text_file(folder / "report.html", report_page(comparison, verdict, ImagePacking::automatic), false);
    return folder / "report.html";
  }
};

std::string text_of(Chromium& page, const std::string& id) {
  return page.evaluate("document.getElementById('" + id + "').textContent");
}

double number(Chromium& page, const std::string& expression) {
  return page.evaluate(expression).get<double>();
}

/// What is seen of the test, in pixels of the screen from the left of the stage.
double divider(Chromium& page) {
  return number(page, "parseFloat(document.getElementById('divider').style.left)");
}

void expect_quiet(const Chromium& page) {
  for (const std::string& problem : page.problems()) ADD_FAILURE() << problem;
}

TEST_F(ReportTest, everything_is_there_on_a_desktop) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  EXPECT_NE(text_of(page, "verdict").find("Fail"), std::string::npos) << text_of(page, "verdict");
  EXPECT_NE(text_of(page, "tiles").find("FLIP"), std::string::npos);
  EXPECT_EQ(number(page, "document.querySelectorAll('#scene img').length"), 4) << "two pictures, two maps";
  EXPECT_TRUE(
      page.evaluate("[...document.images].every(image => image.complete && image.naturalWidth === 120)")
          .get<bool>());
  EXPECT_EQ(number(page, "document.querySelectorAll('#views button').length"), 6);
  EXPECT_EQ(number(page, "document.querySelectorAll('#regions button').length"), 2);
  EXPECT_EQ(number(page, "document.querySelectorAll('#metrics tr.bad').length"), 1)
      << "the threshold that fails";
  EXPECT_GE(number(page, "document.querySelectorAll('#histograms svg').length"), 2);
  EXPECT_NE(text_of(page, "provenance").find("alidade:samples1664"), std::string::npos)
      << text_of(page, "provenance");
  expect_quiet(page);
}

TEST_F(ReportTest, names_and_metadata_are_text_and_never_html) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  EXPECT_NE(text_of(page, "names").find("<img src=x onerror=hacked()>'\".png"), std::string::npos)
      << text_of(page, "names");
  EXPECT_NE(text_of(page, "provenance").find(k_hostile), std::string::npos) << text_of(page, "provenance");
  EXPECT_EQ(page.evaluate("document.title"), "<img src=x onerror=hacked()>'\".png against wave.png");
  EXPECT_EQ(page.evaluate("typeof window.hacked"), "undefined");
  EXPECT_EQ(number(page, "document.querySelectorAll('img[onerror]').length"), 0);
  expect_quiet(page);
}

TEST_F(ReportTest, the_divider_follows_keys_the_slider_and_the_mouse) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  const double width = number(page, "document.getElementById('stage').clientWidth");
  EXPECT_NEAR(divider(page), 0.5 * width, 1.0);
  page.press("ArrowRight");
  EXPECT_NEAR(divider(page), 0.52 * width, 1.0);
  page.press("ArrowLeft");
  page.press("ArrowLeft");
  EXPECT_NEAR(divider(page), 0.48 * width, 1.0);
  EXPECT_EQ(
      page.evaluate("document.getElementById('picture-test').style.clipPath"),
      page.evaluate("`inset(0px 0px 0px ${parseFloat(document.getElementById('divider').style.left)}px)`"));
  const double left = number(page, "document.getElementById('stage').getBoundingClientRect().left");
  const double top = number(page, "document.getElementById('stage').getBoundingClientRect().top") + 50.0;
  page.drag(left + 0.5 * width, top, left + 0.25 * width, top);
  EXPECT_NEAR(divider(page), 0.25 * width, 4.0);
  page.evaluate(
      "(s => { s.value = 75; s.dispatchEvent(new Event('input')); })(document.getElementById('swipe'))");
  EXPECT_NEAR(divider(page), 0.75 * width, 1.0);
  expect_quiet(page);
}

TEST_F(ReportTest, arrows_move_a_zoomed_image_and_letters_go_through_the_regions) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  const std::string transform = "document.getElementById('scene').style.transform";
  const auto whole = page.evaluate(transform);
  page.press("ArrowDown");
  EXPECT_EQ(page.evaluate(transform), whole) << "all of it is seen";
  page.press("+");
  page.press("+");
  EXPECT_GT(number(page, "new DOMMatrix(" + transform + ").a"), 1.5);
  const auto x = [&] { return number(page, "new DOMMatrix(" + transform + ").e"); };
  const auto y = [&] { return number(page, "new DOMMatrix(" + transform + ").f"); };
  const double left = x(), top = y(), split = divider(page);
  page.press("ArrowRight");
  page.press("ArrowUp");
  EXPECT_NEAR(x(), left - 40.0, 0.5);
  EXPECT_NEAR(y(), top + 40.0, 0.5);
  EXPECT_EQ(divider(page), split);
  page.press("0");
  EXPECT_EQ(number(page, "new DOMMatrix(" + transform + ").a"), 1.0);
  const std::string current =
      "document.querySelector('#regions [aria-current=true]').textContent.slice(0, 2)";
  page.press("n");
  EXPECT_EQ(page.evaluate(current), "1.");
  page.press("n");
  EXPECT_EQ(page.evaluate(current), "2.");
  page.press("p");
  EXPECT_EQ(page.evaluate(current), "1.");
  expect_quiet(page);
}

TEST_F(ReportTest, matched_colours_warnings_and_how_it_was_compared_are_reported) {
  write_images();
  ComparisonOptions options;
  options.match = ColorModel::exposure;
  options.crop = image::PixelBox{0, 0, 120, 60};
  options.keep_images = true;
  const Comparison comparison = compare_files(folder / "wave.png", folder / "wave.png", options);
  write_text_file(folder / "report.html",
                  report_page(comparison, judge(comparison, parse_thresholds("flip=0.5")), ImagePacking::jpeg,
                              judge(comparison, parse_thresholds("flip>-1"))),
                  false);
  Chromium page(folder, 390, 844);
  page.open(folder / "report.html");
  EXPECT_EQ(text_of(page, "verdict"),
            "PassThe threshold is kept. Warning: flip is 0, wished at most \u22121.");
  EXPECT_NE(text_of(page, "how").find("0,0,120,60"), std::string::npos) << text_of(page, "how");
  EXPECT_NE(text_of(page, "views").find("FLIP, colours matched"), std::string::npos)
      << text_of(page, "views");
  EXPECT_NE(text_of(page, "metrics").find("warns"), std::string::npos);
  EXPECT_EQ(page.evaluate("[...document.images].every(image => image.src.startsWith('data:image/jpeg') && "
                          "image.naturalHeight === 60)"),
            true);
  EXPECT_EQ(number(page, "document.documentElement.scrollWidth"), 390);
  expect_quiet(page);
}

TEST_F(ReportTest, images_with_layers_only_have_a_page_too) {
  std::vector<float> layers;
  for (int i = 0; i < 120 * 80; ++i) layers.insert(layers.end(), {5.0f, 0.0f, 0.0f, 1.0f});
  write_layers("a.exr", 120, 80, {"Z", "N.X", "N.Y", "N.Z"}, layers);
  layers[4 * 121] = 6.0f;
  write_layers("b.exr", 120, 80, {"Z", "N.X", "N.Y", "N.Z"}, layers);
  ComparisonOptions options;
  options.keep_images = true;
  const Comparison comparison = compare_files(folder / "a.exr", folder / "b.exr", options);
  write_text_file(folder / "report.html", report_page(comparison, {}, ImagePacking::automatic), false);
  Chromium page(folder, 1280, 900);
  page.open(folder / "report.html");
  EXPECT_NE(text_of(page, "verdict").find("Measured"), std::string::npos);
  EXPECT_EQ(number(page, "document.querySelectorAll('#scene img').length"), 3) << "two pictures, one map";
  EXPECT_NE(text_of(page, "metrics").find("at 1, 1"), std::string::npos) << text_of(page, "metrics");
  expect_quiet(page);
}

TEST_F(ReportTest, the_map_of_agreement_has_a_legend_of_categories) {
  std::vector<float> layers;
  for (int i = 0; i < 120 * 80; ++i) layers.insert(layers.end(), {5.0f, 0.1f});
  write_layers("a.exr", 120, 80, {"Z", "depth.sigma"}, layers);
  layers[2 * 121] = 6.0f;
  write_layers("b.exr", 120, 80, {"Z", "depth.sigma"}, layers);
  ComparisonOptions options;
  options.keep_images = true;
  const Comparison comparison = compare_files(folder / "a.exr", folder / "b.exr", options);
  write_text_file(folder / "report.html", report_page(comparison, {}, ImagePacking::automatic), false);
  Chromium page(folder, 1280, 900);
  page.open(folder / "report.html");
  EXPECT_NE(text_of(page, "metrics").find("Not scanned"), std::string::npos) << text_of(page, "metrics");
  page.press("m");
  EXPECT_FALSE(page.evaluate("document.getElementById('legend').hidden").get<bool>());
  EXPECT_TRUE(page.evaluate("document.getElementById('categories').hidden").get<bool>());
  page.press("m");
  EXPECT_TRUE(page.evaluate("document.getElementById('legend').hidden").get<bool>());
  EXPECT_FALSE(page.evaluate("document.getElementById('categories').hidden").get<bool>());
  EXPECT_EQ(text_of(page, "categories"), "differsnot scannedagreesnothing in either");
  EXPECT_NE(page.evaluate("getComputedStyle(document.querySelector('#categories span')).backgroundColor"),
            "rgba(0, 0, 0, 0)");
  page.press("r");
  EXPECT_TRUE(page.evaluate("document.getElementById('categories').hidden").get<bool>());
  expect_quiet(page);
}

TEST_F(ReportTest, b_blinks_and_space_switches) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  page.press("b");
  EXPECT_EQ(page.evaluate("document.getElementById('blink-run').getAttribute('aria-pressed')"), "true");
  const std::string seen = "document.querySelector('#scene img.shown').id";
  const std::string other_soon = "new Promise(done => { const first = " + seen + "; const check = () => " +
                                 seen + " !== first ? done(true) : setTimeout(check, 20); check(); })";
  EXPECT_TRUE(page.evaluate(other_soon).get<bool>());
  page.press("b");
  EXPECT_EQ(page.evaluate("document.getElementById('blink-run').getAttribute('aria-pressed')"), "false");
  const auto before = page.evaluate(seen);
  page.press(" ");
  EXPECT_NE(page.evaluate(seen), before);
  expect_quiet(page);
}

TEST_F(ReportTest, maps_have_legends_and_regions_jump_to_a_crop) {
  Chromium page(folder, 1280, 900);
  page.open(write_report());
  page.press("m");
  EXPECT_FALSE(page.evaluate("document.getElementById('legend').hidden").get<bool>());
  EXPECT_NE(text_of(page, "legend-high"), "");
  EXPECT_NE(page.evaluate("getComputedStyle(document.getElementById('legend-bar')).backgroundImage"), "none");
  page.evaluate("document.querySelector('#regions button').click()");
  EXPECT_EQ(number(page, "document.querySelectorAll('#crops canvas').length"), 4);
  // The largest region, [10, 30) x [10, 25), is in the middle of the stage as far as the border lets it.
  EXPECT_GT(number(page, "new DOMMatrix(getComputedStyle(document.getElementById('scene')).transform).a"),
            1.5);
  EXPECT_TRUE(
      page.evaluate("(() => { const stage = document.getElementById('stage').getBoundingClientRect(), "
                    "box = document.getElementById('box').getBoundingClientRect(); return box.width > 0 && "
                    "box.left >= stage.left && box.right <= stage.right && box.top >= stage.top && "
                    "box.bottom <= stage.bottom; })()")
          .get<bool>());
  expect_quiet(page);
}

TEST_F(ReportTest, on_a_phone_nothing_is_wider_than_the_screen_and_controls_have_labels) {
  Chromium page(folder, 390, 844);
  page.open(write_report());
  EXPECT_EQ(number(page, "document.documentElement.scrollWidth"), 390);
  EXPECT_EQ(page.evaluate("[...document.querySelectorAll('button, input, [role=img], img')].filter(e => "
                          "!(e.textContent.trim() || e.alt || e.ariaLabel || e.getAttribute('aria-label') || "
                          "(e.labels && e.labels.length))).map(e => e.outerHTML.slice(0, 80))"),
            nlohmann::json::array());
  EXPECT_EQ(page.evaluate("[...document.querySelectorAll('button')].filter(e => e.offsetParent && "
                          "e.getBoundingClientRect().height < 36).length"),
            0)
      << "fingers need room";
  expect_quiet(page);
}

TEST_F(ReportTest, a_summary_without_thresholds_passes_nobody) {
  write_images();
  BatchOptions options;
  options.keep_thumbnails = true;
  const std::vector<PairOutcome> outcomes =
      compare_pairs({{"itself", folder / "wave.png", folder / "wave.png"}}, options);
  write_text_file(folder / "summary.html", summary_page(outcomes, "a", "b", folder / "summary.html"), false);
  Chromium page(folder, 1280, 900);
  page.open(folder / "summary.html");
  EXPECT_EQ(text_of(page, "verdict"), "Measured1 pair compared. No thresholds were given.");
  EXPECT_NE(text_of(page, "pairs").find("PSNR ∞ ·"), std::string::npos) << text_of(page, "pairs");
  EXPECT_EQ(number(page, "document.querySelectorAll('.badge.good').length"), 0);
  expect_quiet(page);
}

TEST_F(ReportTest, a_summary_lists_pairs_worst_first_and_filters_them) {
  write_images();
  fs::create_directories(folder / "a");
  fs::create_directories(folder / "b");
  for (const char* const name : {"same.png", "squares.png", "lost.png"})
    fs::copy(folder / "wave.png", folder / "a" / name);
  fs::copy(folder / "wave.png", folder / "b/same.png");
  fs::copy(folder / "<img src=x onerror=hacked()>'\".png", folder / "b/squares.png");
  BatchOptions options;
  options.fail_above = parse_thresholds("flip=0.001");
  options.keep_thumbnails = true;
  options.reports = folder / "pages";
  const std::vector<PairOutcome> outcomes =
      compare_pairs(pairs_of_folders(folder / "a", folder / "b"), options);
  write_text_file(folder / "summary.html", summary_page(outcomes, "a", "<b>b</b>", folder / "summary.html"),
                  false);

  Chromium page(folder, 390, 844);
  page.open(folder / "summary.html");
  EXPECT_EQ(page.evaluate("[...document.querySelectorAll('#pairs h3')].map(e => e.textContent)"),
            nlohmann::json({"lost.png", "squares.png", "same.png"}));
  EXPECT_EQ(
      page.evaluate("[...document.querySelectorAll('#pairs a')].map(e => decodeURI(e.getAttribute('href')))"),
      nlohmann::json({"pages/squares.png.html", "pages/same.png.html"}));
  EXPECT_TRUE(fs::exists(folder / "pages/squares.png.html"));
  page.evaluate("document.getElementById('only-failed').click()");
  EXPECT_EQ(number(page, "[...document.querySelectorAll('#pairs li')].filter(e => e.offsetParent).length"),
            2);
  EXPECT_EQ(number(page, "document.documentElement.scrollWidth"), 390);
  expect_quiet(page);
}

}  // namespace
}  // namespace alidade::test
