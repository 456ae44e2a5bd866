// SPDX-License-Identifier: MIT
#include "compare/report/report_page.h"

#include <fmt/format.h>

#include "base/parallel.h"
#include "compare/report/comparison_json.h"
#include "compare/report/page.h"
#include "image/canvas.h"
#include "image/font.h"

namespace alidade::compare {
namespace {

/// An image of the page.
struct PageImage {
  std::string id, title;
  const image::ByteImage* image = nullptr;
  const DifferenceMap* map = nullptr;  ///< the map that the image shows; null for compared images
  std::string data_url{};
};

std::string name_of(const ComparedImageFacts& facts) {
  return facts.file.filename().string();
}

Json image_json(const ComparedImageFacts& facts) {
  return {{"name", name_of(facts)}, {"size", {facts.width, facts.height}}, {"metadata", facts.metadata}};
}

Json rows_json(const Comparison& comparison) {
  Json rows = Json::array();
  for (const Metric& metric : metrics_of(comparison)) {
    Json row{{"name", metric.kind->name},         {"group", metric.kind->group},
             {"label", metric.kind->label},       {"full_label", full_label(*metric.kind)},
             {"unit", metric.kind->unit},         {"note", metric.kind->note},
             {"value", json_number(metric.value)}};
    if (metric.position) row["at"] = {metric.position->x, metric.position->y};
    rows.push_back(row);
  }
  return rows;
}

std::string css_color(const image::Rgb8& color) {
  return fmt::format("rgb({},{},{})", color[0], color[1], color[2]);
}

/// The colours of a map from its lowest value to its highest, for CSS.
Json colors_of(const DifferenceMap& map) {
  constexpr int k_steps = 33;
  DifferenceMap ramp;
  ramp.colors = map.colors;
  ramp.range = map.range;
  ramp.width = k_steps;
  ramp.height = 1;
  ramp.values.resize(k_steps);
  for (int i = 0; i < k_steps; ++i)
    ramp.values[static_cast<std::size_t>(i)] =
        static_cast<float>(map.range.low + (map.range.high - map.range.low) * i / (k_steps - 1));
  const image::Canvas canvas = paint_difference(ramp);
  Json colors = Json::array();
  for (int i = 0; i < k_steps; ++i) colors.push_back(css_color(canvas.at(i, 0)));
  return colors;
}

Json map_json(const PageImage& image, const DifferenceMap& map) {
  std::string note = map.title + ": " + map.label + ".";
  for (const std::string& line : map.notes) note += " " + line + ".";
  Json json{{"id", image.id}, {"kind", "map"}, {"title", map.title}, {"note", note}};
  if (!map.categories.empty()) {
    Json categories = Json::array();
    const auto add = [&](const std::string& label, const image::Rgb8& color) {
      categories.push_back({{"label", label}, {"color", css_color(color)}});
    };
    for (auto category = map.categories.rbegin(); category != map.categories.rend(); ++category)
      add(category->label, category->color);
    if (!map.mask.counts.empty()) add("excluded", k_excluded_color);
    json["categories"] = categories;
    return json;
  }
  json["low"] = fmt::format("{:.3g}", map.range.low);
  json["high"] = fmt::format("{:.3g}", map.range.high);
  json["colors"] = colors_of(map);
  return json;
}

/// `images` are the reference, the test, the test with matched colours if there is one, and maps.
Json views_json(const std::vector<PageImage>& images) {
  const PageImage& reference = images.front();
  const bool has_matched = images.size() > 2 && images[2].id == "matched";
  const PageImage& test = images[has_matched ? 2 : 1];
  const auto view_of_both = [&](const char* kind, const char* title, const char* note) {
    return Json{{"id", kind},          {"kind", kind},
                {"title", title},      {"under", reference.id},
                {"over", test.id},     {"left", reference.title},
                {"right", test.title}, {"note", note}};
  };
  Json views = {
      view_of_both("swipe", "Swipe", "The reference left of the divider, the test right of it."),
      view_of_both("blink", "Blink",
                   "Reference and test in turn at the same position: what moves or flickers differs.")};
  for (const PageImage& image : images) {
    views.push_back(image.map != nullptr ? map_json(image, *image.map)
                                         : Json{{"id", image.id},
                                                {"kind", "picture"},
                                                {"title", image.title},
                                                {"note", image.title + "."}});
  }
  return views;
}

std::string plural(std::uint64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string regions_note(const Comparison& comparison) {
  if (!comparison.changes) return {};
  const ChangeRegions& changes = *comparison.changes;
  std::string note =
      fmt::format("{} of {} pixels have changed, {} of them in {}", changes.changed_pixels,
                  comparison.counted, changes.listed_pixels, plural(changes.regions.size(), "region"));
  if (changes.small_regions > 0)
    note += fmt::format("; {} of fewer than {} pixels left out", plural(changes.small_regions, "region"),
                        comparison.options.changes.least_pixels);
  if (changes.further_regions > 0)
    note += fmt::format("; {} further ones not listed", changes.further_regions);
  return note + ".";
}

Json histogram_json(const HistogramChart& chart) {
  const auto bins_of = [](const Histogram& histogram) {
    return Json{{"name", histogram.name}, {"bins", histogram.bins}};
  };
  Json json{{"title", chart.title},
            {"unit", chart.unit},
            {"low", chart.low},
            {"high", chart.high},
            {"first", bins_of(chart.first)}};
  if (chart.second) json["second"] = bins_of(*chart.second);
  return json;
}

std::string counted_note(const Comparison& comparison) {
  std::string note = fmt::format("{} of {} pixels count", comparison.counted, comparison.pixels);
  if (comparison.excluded > 0)
    note += fmt::format("; {} of them have no finite colour and are in no figure of colours",
                        comparison.excluded);
  return note + ".";
}

Json lines_json(const std::vector<HowLine>& lines) {
  Json json = Json::array();
  for (const HowLine& line : lines) json.push_back({line.name, line.text});
  return json;
}

Json page_json(const Comparison& comparison, const Verdict& verdict, const Verdict& warnings,
               const std::vector<PageImage>& images) {
  Json histograms = Json::array();
  for (const HistogramChart& chart : comparison.images->histograms)
    histograms.push_back(histogram_json(chart));
  return {{"generator", "Alidade " ALIDADE_VERSION},
          {"reference", image_json(comparison.reference)},
          {"test", image_json(comparison.test)},
          {"pass", verdict.pass()},
          {"thresholds", thresholds_json(verdict)},
          {"warnings", thresholds_json(warnings)},
          {"remarks", comparison.remarks},
          {"tiles", {"flip", "ssim", "psnr", "rmse", "depth_mean", "shift"}},
          {"rows", rows_json(comparison)},
          {"counted_note", counted_note(comparison)},
          {"how", lines_json(how_lines(comparison))},
          {"views", views_json(images)},
          {"regions", comparison.changes ? regions_json(*comparison.changes) : Json::array()},
          {"regions_note", regions_note(comparison)},
          {"histograms", histograms}};
}

}  // namespace

std::string report_page(const Comparison& comparison, const Verdict& verdict, image::ImagePacking packing,
                        const Verdict& warnings) {
  const ComparisonImages& compared = *comparison.images;
  std::vector<image::ByteImage> painted;
  const std::vector<const DifferenceMap*> maps = compared.maps();
  for (const DifferenceMap* map : maps)
    painted.push_back({map->width, map->height, paint_difference(*map).bytes()});
  std::vector<PageImage> images{{"reference", "Reference", &compared.reference},
                                {"test", "Test", &compared.test}};
  if (compared.matched) images.push_back({"matched", "Test, colours matched", &*compared.matched});
  for (std::size_t i = 0; i < painted.size(); ++i)
    images.push_back({fmt::format("map-{}", i + 1), maps[i]->title, &painted[i], maps[i]});
  in_parallel(images.size(), 1,
              [&](std::size_t i) { images[i].data_url = image::data_url(*images[i].image, packing); });

  std::string elements;
  for (const PageImage& image : images)
    elements += fmt::format("<img id=\"picture-{}\" alt=\"{}\" src=\"{}\">\n", image.id,
                            html_text(image.title), image.data_url);
  const std::string title = html_text(name_of(comparison.test) + " against " + name_of(comparison.reference));
  const std::string data = script_json(json_text(page_json(comparison, verdict, warnings, images), -1));
  const std::string script = std::string(k_page_js) + std::string(k_tables_js) + std::string(k_viewer_js);
  return fill_page(
      k_report_html,
      {{"title", title}, {"style", k_style_css}, {"pictures", elements}, {"data", data}, {"script", script}});
}

}  // namespace alidade::compare
