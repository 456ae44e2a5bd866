// SPDX-License-Identifier: MIT
#include "visibility/horizon/skyline_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>

#include "image/canvas.h"
#include "image/color_map.h"
#include "image/image_file.h"
#include "image/legend.h"

namespace alidade::visibility {
namespace {

constexpr image::Rgb8 k_paper{255, 255, 255}, k_ink{30, 30, 30}, k_faint_ink{95, 95, 95},
    k_sky{232, 241, 250}, k_horizon{205, 30, 45};
constexpr int k_font_size = 17, k_title_size = 20, k_note_size = 15, k_tick = 6, k_gap = 8;

/// Distances from the nearest to the farthest colour.
struct DistanceScale {
  double near = 1.0, far = 10.0;

  /// 0 at `near`, 1 at `far`.
  double share(double distance) const { return std::log(distance / near) / std::log(far / near); }
  image::Rgb8 color(double distance) const {
    const glm::dvec3 display = image::map_color(image::ColorMap::viridis, share(distance));
    const auto byte = [](double value) { return static_cast<std::uint8_t>(std::lround(255.0 * value)); };
    return {byte(display.x), byte(display.y), byte(display.z)};
  }
};

DistanceScale scale_of(const DepthStrip& strip) {
  std::vector<float> seen;
  for (const float distance : strip.distances)
    if (std::isfinite(distance) && distance > 0.0f) seen.push_back(distance);
  if (seen.empty()) return {};
  std::ranges::sort(seen);
  // Without the nearest 1 %: a leaf in front of the eye must not take half of the colours.
  const auto at = [&](double share) {
    return static_cast<double>(seen[static_cast<std::size_t>(share * static_cast<double>(seen.size() - 1))]);
  };
  DistanceScale scale{at(0.01), at(0.999)};
  constexpr double k_least_ratio = 1.5;
  scale.far = std::max(scale.far, k_least_ratio * scale.near);
  return scale;
}

/// 1, 2 and 5 times powers of ten between the ends of the scale.
std::vector<double> distance_ticks(const DistanceScale& scale) {
  std::vector<double> ticks;
  for (int power = static_cast<int>(std::floor(std::log10(scale.near))); std::pow(10.0, power) <= scale.far;
       ++power) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (value >= scale.near && value <= scale.far) ticks.push_back(value);
    }
  }
  return ticks;
}

/// Where the plot lies on the canvas.
struct Frame {
  image::PixelBox plot, bar;

  double column(const DepthStrip& strip, double azimuth) const {
    return plot.left + (azimuth - strip.azimuth_min) / (strip.azimuth_max - strip.azimuth_min) * plot.width();
  }
  double row(const DepthStrip& strip, double elevation) const {
    return plot.top +
           (strip.elevation_max - elevation) / (strip.elevation_max - strip.elevation_min) * plot.height();
  }
};

/// Draws texts with a given left end, middle or right end.
class Writer {
 public:
  Writer(image::Canvas& canvas, const image::Font& font) : canvas_(canvas), font_(font) {}

  int width(const std::string& text, int size) const { return font_.measure(text, size).width; }
  void left(int x, int baseline, const std::string& text, int size, const image::Rgb8& color) {
    font_.draw(canvas_, x, baseline, text, size, color);
  }
  void center(int x, int baseline, const std::string& text, int size, const image::Rgb8& color) {
    left(x - width(text, size) / 2, baseline, text, size, color);
  }
  void right(int x, int baseline, const std::string& text, int size, const image::Rgb8& color) {
    left(x - width(text, size), baseline, text, size, color);
  }

 private:
  image::Canvas& canvas_;
  const image::Font& font_;
};

void draw_view(const DepthStrip& strip, const DistanceScale& scale, const image::PixelBox& plot,
               image::Canvas& canvas) {
  canvas.fill(plot, k_sky);
  for (int y = 0; y < strip.height; ++y) {
    for (int x = 0; x < strip.width; ++x) {
      const float distance = strip.distances[static_cast<std::size_t>(y) * strip.width + x];
      if (std::isfinite(distance)) {
        canvas.fill({plot.left + x, plot.top + y, plot.left + x + 1, plot.top + y + 1},
                    scale.color(std::max(static_cast<double>(distance), scale.near)));
      }
    }
  }
}

/// Row of the horizon in the middle of a column; empty if nothing blocks the view there.
std::optional<double> horizon_row(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                                  const Frame& frame, int x) {
  const double azimuth =
      strip.azimuth_min + (x + 0.5) / strip.width * (strip.azimuth_max - strip.azimuth_min);
  const auto away = [&](const HorizonDirection& direction) {
    return std::fabs(std::remainder(direction.azimuth - azimuth, 360.0));
  };
  const auto nearest = std::ranges::min_element(horizon, {}, away);
  if (nearest == horizon.end() || !nearest->elevation) return {};
  return frame.row(strip, *nearest->elevation);
}

/// The part of a column between two rows; the pixels at its ends by the share of them that it covers.
void draw_span(image::Canvas& canvas, const image::PixelBox& plot, int x, double top, double bottom,
               const image::Rgb8& color) {
  for (int y = std::max(static_cast<int>(std::floor(top)), plot.top);
       y < std::min(static_cast<int>(std::ceil(bottom)), plot.bottom); ++y) {
    const double cover = std::min(bottom, y + 1.0) - std::max(top, static_cast<double>(y));
    canvas.blend(x, y, color, static_cast<int>(std::lround(255.0 * std::clamp(cover, 0.0, 1.0))));
  }
}

void draw_line(const DepthStrip& strip, std::span<const HorizonDirection> horizon, const Frame& frame,
               image::Canvas& canvas) {
  constexpr double k_half_width = 1.0;
  std::optional<double> before;
  for (int x = 0; x < strip.width; ++x) {
    const std::optional<double> row = horizon_row(strip, horizon, frame, x);
    if (row) {
      const double other = before.value_or(*row);
      draw_span(canvas, frame.plot, frame.plot.left + x, std::min(*row, other) - k_half_width,
                std::max(*row, other) + k_half_width, k_horizon);
    }
    before = row;
  }
}

/// Covers the pixels within half a width of a stretch between two positions of the canvas;
/// those at the edge in part.
void draw_stretch(image::Canvas& canvas, const glm::dvec2& from, const glm::dvec2& to, double width,
                  const std::function<void(int x, int y, double cover)>& paint) {
  const double reach = 0.5 * width + 1.0;
  const glm::dvec2 low = glm::min(from, to) - reach, high = glm::max(from, to) + reach, way = to - from;
  const double length_sq = glm::dot(way, way);
  for (int y = std::max(static_cast<int>(low.y), 0);
       y < std::min(static_cast<int>(high.y) + 1, canvas.height()); ++y) {
    for (int x = std::max(static_cast<int>(low.x), 0);
         x < std::min(static_cast<int>(high.x) + 1, canvas.width()); ++x) {
      const glm::dvec2 pixel(x + 0.5, y + 0.5);
      const double share =
          length_sq > 0.0 ? std::clamp(glm::dot(pixel - from, way) / length_sq, 0.0, 1.0) : 0.0;
      const double cover = 0.5 * width + 0.5 - glm::distance(pixel, from + share * way);
      if (cover > 0.0) paint(x, y, std::min(cover, 1.0));
    }
  }
}

/// Draws a curve by a mask of its cover, so that stretches that meet do not cover a pixel twice.
void draw_curve(const DepthStrip& strip, const SkylineCurve& curve, const Frame& frame,
                image::Canvas& canvas) {
  constexpr double k_hidden = 0.3, k_dot = 7.0;
  const image::PixelBox& plot = frame.plot;
  std::vector<float> covers(static_cast<std::size_t>(plot.width()) * static_cast<std::size_t>(plot.height()));
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y - plot.top) * static_cast<std::size_t>(plot.width()) +
           static_cast<std::size_t>(x - plot.left);
  };
  const auto add = [&](int x, int y, double cover) {
    if (x < plot.left || x >= plot.right || y < plot.top || y >= plot.bottom) return;
    covers[index(x, y)] = std::max(covers[index(x, y)], static_cast<float>(cover));
  };
  const auto on_canvas = [&](const glm::dvec2& position) {
    return glm::dvec2(frame.column(strip, position.x), frame.row(strip, position.y));
  };
  for (std::size_t i = 1; i < curve.positions.size(); ++i) {
    const glm::dvec2 &from = curve.positions[i - 1], &to = curve.positions[i];
    if (std::fabs(from.x - to.x) < 180.0)
      draw_stretch(canvas, on_canvas(from), on_canvas(to), curve.width, add);
  }
  for (const SkylineCurve::Mark& mark : curve.marks)
    draw_stretch(canvas, on_canvas(mark.position), on_canvas(mark.position), k_dot, add);
  for (int y = plot.top; y < plot.bottom; ++y) {
    for (int x = plot.left; x < plot.right; ++x) {
      const bool is_hidden = std::isfinite(strip.distances[index(x, y)]);
      const double cover = covers[index(x, y)] * (is_hidden ? k_hidden : 1.0);
      if (cover > 0.0)
        canvas.blend(x, y, is_hidden ? k_paper : curve.color, static_cast<int>(std::lround(255.0 * cover)));
    }
  }
}

/// Draws the labels of a curve, bright over what hides the sky.
void label_curve(const DepthStrip& strip, const SkylineCurve& curve, const Frame& frame, Writer& writer) {
  constexpr int k_above = 9;
  const auto write = [&](const glm::dvec2& position, int above, const std::string& label,
                         const image::Rgb8& color) {
    const int x = static_cast<int>(std::lround(frame.column(strip, position.x))),
              y = static_cast<int>(std::lround(frame.row(strip, position.y)));
    if (y <= frame.plot.top + above + k_note_size || y >= frame.plot.bottom) return;
    const int column = std::clamp(x - frame.plot.left, 0, strip.width - 1), row = y - above - frame.plot.top;
    const float seen = strip.distances[static_cast<std::size_t>(row) * static_cast<std::size_t>(strip.width) +
                                       static_cast<std::size_t>(column)];
    const bool is_sky = !std::isfinite(seen);
    // A rim of the other brightness: a label may lie across an edge.
    for (const auto& [right, down] : {std::pair{-1, 0}, std::pair{1, 0}, std::pair{0, -1}, std::pair{0, 1}})
      writer.center(x + right, y - above + down, label, k_note_size, is_sky ? k_sky : k_ink);
    writer.center(x, y - above, label, k_note_size, is_sky ? color : k_paper);
  };
  for (const SkylineCurve::Mark& mark : curve.marks) write(mark.position, k_above, mark.label, k_ink);
  if (curve.positions.empty() || curve.label.empty()) return;
  const auto highest =
      std::ranges::max_element(curve.positions, {}, [](const glm::dvec2& one) { return one.y; });
  const bool has_names =
      std::ranges::any_of(curve.marks, [](const auto& mark) { return !mark.label.empty(); });
  write(*highest, k_above + (has_names ? k_note_size + 4 : 0), curve.label, curve.color);
}

/// The narrowest of the usual steps of a compass that gives at most `most` ticks.
double compass_step(double range, int most) {
  for (const double step : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0})
    if (range / step <= most) return step;
  return 90.0;
}

std::string compass_name(double azimuth) {
  static constexpr const char* k_names[] = {"N", "NE", "E", "SE", "S", "SW", "W", "NW"};
  const double eighth = azimuth / 45.0;
  if (std::fabs(eighth - std::round(eighth)) > 1e-9) return {};
  const int number = static_cast<int>(std::lround(eighth)) % 8;
  return k_names[number < 0 ? number + 8 : number];
}

void draw_axes(const DepthStrip& strip, const Frame& frame, image::Canvas& canvas, Writer& writer) {
  const image::PixelBox& plot = frame.plot;
  canvas.frame({plot.left - 1, plot.top - 1, plot.right + 1, plot.bottom + 1}, k_faint_ink);
  const int labels = plot.bottom + k_tick + k_gap + k_font_size;
  constexpr double k_slack = 1e-9;
  constexpr int k_most_azimuths = 12, k_most_elevations = 9;
  const double step = compass_step(strip.azimuth_max - strip.azimuth_min, k_most_azimuths);
  for (double i = std::ceil(strip.azimuth_min / step - k_slack); i * step <= strip.azimuth_max + k_slack;
       ++i) {
    const int x = static_cast<int>(std::lround(frame.column(strip, i * step)));
    canvas.fill({x, plot.bottom + 1, x + 1, plot.bottom + 1 + k_tick}, k_faint_ink);
    const double degrees = i * step + 0.0;
    const double shown = degrees < 0.0 ? degrees + 360.0 : degrees > 360.0 ? degrees - 360.0 : degrees;
    writer.center(x, labels, fmt::format("{:g}°", shown), k_font_size, k_ink);
  }
  for (double i = std::ceil(strip.azimuth_min / 45.0 - k_slack); i * 45.0 <= strip.azimuth_max + k_slack; ++i)
    writer.center(static_cast<int>(std::lround(frame.column(strip, i * 45.0))), labels + k_font_size + 4,
                  compass_name(i * 45.0), k_font_size, k_faint_ink);
  for (const image::RoundTick& tick :
       image::round_ticks({strip.elevation_min, strip.elevation_max}, k_most_elevations)) {
    const int y = static_cast<int>(std::lround(frame.row(strip, tick.value)));
    canvas.fill({plot.left - 1 - k_tick, y, plot.left - 1, y + 1}, k_faint_ink);
    writer.right(plot.left - 1 - k_tick - 4, y + k_font_size / 3, tick.label + "°", k_font_size, k_ink);
  }
  // Dashes at eye level.
  const int level = static_cast<int>(std::lround(frame.row(strip, 0.0)));
  constexpr int k_dash = 8, k_dash_cover = 150;
  for (int x = plot.left; x < plot.right; ++x)
    if ((x - plot.left) / k_dash % 2 == 0 && level > plot.top && level < plot.bottom)
      canvas.blend(x, level, k_paper, k_dash_cover);
}

void draw_bar(const DistanceScale& scale, const Frame& frame, const std::string& unit, image::Canvas& canvas,
              Writer& writer) {
  const image::PixelBox& bar = frame.bar;
  const double ratio = scale.far / scale.near;
  for (int y = bar.top; y < bar.bottom; ++y) {
    const double share = static_cast<double>(bar.bottom - 1 - y) / (bar.height() - 1);
    canvas.fill({bar.left, y, bar.right, y + 1}, scale.color(scale.near * std::pow(ratio, share)));
  }
  canvas.frame({bar.left - 1, bar.top - 1, bar.right + 1, bar.bottom + 1}, k_faint_ink);
  for (const double tick : distance_ticks(scale)) {
    const int y = bar.bottom - 1 - static_cast<int>(std::lround(scale.share(tick) * (bar.height() - 1)));
    canvas.fill({bar.right + 1, y, bar.right + 1 + k_tick, y + 1}, k_faint_ink);
    writer.left(bar.right + 1 + k_tick + 4, y + k_font_size / 3,
                fmt::format("{:g}{}{}", tick, unit.empty() ? "" : " ", unit), k_font_size, k_ink);
  }
  writer.left(bar.left, bar.top - k_gap - 2, "distance", k_font_size, k_ink);
}

}  // namespace

image::Canvas draw_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                           const SkylineTexts& texts, const image::Font& font) {
  constexpr int k_left = 70, k_top = 64, k_bottom = 116, k_bar_gap = 34, k_bar_width = 22, k_right = 110;
  const int width = k_left + strip.width + k_bar_gap + k_bar_width + k_right;
  image::Canvas canvas(width, k_top + strip.height + k_bottom, k_paper);
  Writer writer(canvas, font);
  const Frame frame{{k_left, k_top, k_left + strip.width, k_top + strip.height},
                    {k_left + strip.width + k_bar_gap, k_top, k_left + strip.width + k_bar_gap + k_bar_width,
                     k_top + strip.height}};
  const DistanceScale scale = scale_of(strip);
  draw_view(strip, scale, frame.plot, canvas);
  draw_line(strip, horizon, frame, canvas);
  for (const SkylineCurve& curve : texts.curves) draw_curve(strip, curve, frame, canvas);
  for (const SkylineCurve& curve : texts.curves) label_curve(strip, curve, frame, writer);
  draw_axes(strip, frame, canvas, writer);
  draw_bar(scale, frame, texts.unit, canvas, writer);
  writer.left(k_left, 30, texts.title, k_title_size, k_ink);
  writer.left(k_left, k_top - k_gap - 2, "elevation", k_note_size, k_faint_ink);
  const int below = k_top + strip.height;
  writer.left(k_left, below + k_bottom - 22, texts.note, k_note_size, k_faint_ink);
  const std::string along = "azimuth, clockwise from grid north";
  writer.right(frame.plot.right, below + k_bottom - 22, along, k_note_size, k_faint_ink);
  return canvas;
}

void write_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                   const SkylineTexts& texts, const std::filesystem::path& file, bool overwrite) {
  const image::Font font(image::find_font());
  image::write_png(draw_skyline(strip, horizon, texts, font), file, overwrite);
}

}  // namespace alidade::visibility
