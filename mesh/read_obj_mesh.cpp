// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/ray.h"
#include "base/text_scanner.h"
#include "base/words.h"
#include "mesh/mesh_builder.h"

// Source: Wavefront Technologies, Object Files (.obj), Advanced Visualizer manual, appendix B1.

namespace alidade {
namespace {

constexpr std::uint64_t k_lines_per_report = 1 << 14;
constexpr Rgb k_no_color{0.5f};

using Words = std::vector<std::string_view>;
using Materials = std::map<std::string, Rgb, std::less<>>;

double require_number(const TextScanner& scanner, const Words& words, std::size_t i) {
  if (i >= words.size()) scanner.fail("too few values");
  if (const auto number = parse_number(words[i])) return *number;
  scanner.fail("invalid value", "a number", "'" + std::string(words[i]) + "'");
}

float require_share(const TextScanner& scanner, const Words& words, std::size_t i) {
  const double value = require_number(scanner, words, i);
  return static_cast<float>(std::isnan(value) ? 0.0 : std::clamp(value, 0.0, 1.0));
}

/// The rest of a line after the keyword, as a name, which may have blanks.
std::string rest_of(const Words& words) {
  const char* const begin = words.size() > 1 ? words[1].data() : nullptr;
  if (begin == nullptr) return {};
  return {begin, words.back().data() + words.back().size()};
}

/// Adds the diffuse colours of an MTL file.
void read_materials(const std::filesystem::path& path, Materials& materials) {
  InputFile file(path);
  TextScanner scanner(file);
  Words words;
  std::string name;
  while (scanner.next_words(words)) {
    if (words[0] == "newmtl") name = rest_of(words);
    // "Kd spectral FILE" and "Kd xyz" have no plain colour.
    if (words[0] == "Kd" && words.size() >= 4 && parse_number(words[1]))
      materials[name] = {require_share(scanner, words, 1), require_share(scanner, words, 2),
                         require_share(scanner, words, 3)};
  }
}

class ObjReader {
 public:
  ObjReader(InputFile& file, std::uint64_t& left_out, const Progress& progress)
      : file_(file), scanner_(file), left_out_(left_out), progress_(progress) {}

  TriangleMesh read() {
    // The data of a line takes about as many bytes as its text.
    check_free_memory(file_.name(), file_.size());
    Words words;
    for (std::uint64_t line = 0; scanner_.next_words(words); ++line) {
      if (line % k_lines_per_report == 0) report(progress_, scanner_.offset(), file_.size());
      if (words.back() == "\\") scanner_.fail("unsupported continued line", "one line for each statement");
      if (words[0] == "v")
        add_vertex(words);
      else if (words[0] == "f")
        add_face(words);
      else if (words[0] == "mtllib")
        add_library(words);
      else if (words[0] == "usemtl")
        use(rest_of(words));
    }
    if (!mesh_.triangle_colors.empty()) mesh_.triangle_colors.resize(mesh_.triangles.size(), k_no_color);
    return std::move(mesh_);
  }

 private:
  void add_vertex(const Words& words) {
    if (mesh_.vertices.size() >= k_most_mesh_parts)
      scanner_.fail("too many vertices", fmt::format("at most {}", k_most_mesh_parts));
    const glm::dvec3 vertex{require_number(scanner_, words, 1), require_number(scanner_, words, 2),
                            require_number(scanner_, words, 3)};
    if (!is_finite(vertex)) scanner_.fail(fmt::format("vertex {} is not finite", mesh_.vertices.size() + 1));
    // One more value is a weight; three more are a colour.
    if (words.size() >= 7) {
      mesh_.vertex_colors.resize(mesh_.vertices.size(), k_no_color);
      Rgb color;
      for (int i = 0; i < 3; ++i)
        color[i] = static_cast<float>(
            linear_from_srgb(require_share(scanner_, words, 4 + static_cast<std::size_t>(i))));
      mesh_.vertex_colors.push_back(color);
    } else if (!mesh_.vertex_colors.empty()) {
      mesh_.vertex_colors.push_back(k_no_color);
    }
    mesh_.vertices.push_back(vertex);
  }

  /// The vertex of "7", "7/1", "7//3" or "-1/2/3".
  std::uint32_t vertex_number(std::string_view word) const {
    const auto number = parse_count<std::int64_t>(word.substr(0, word.find('/')));
    const auto count = static_cast<std::int64_t>(mesh_.vertices.size());
    if (!number || *number == 0 || *number > count || *number < -count)
      scanner_.fail("a face names a vertex that does not exist",
                    fmt::format("numbers from 1 to {}, or from -{} to -1", count, count),
                    "'" + std::string(word) + "'");
    return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : count + *number);
  }

  void add_face(const Words& words) {
    polygon_.clear();
    for (std::size_t i = 1; i < words.size(); ++i) polygon_.push_back(vertex_number(words[i]));
    const std::size_t before = mesh_.triangles.size();
    add_fan(file_.name(), polygon_, mesh_, left_out_);
    if (!color_) return;
    mesh_.triangle_colors.resize(before, k_no_color);
    mesh_.triangle_colors.resize(mesh_.triangles.size(), *color_);
  }

  void add_library(const Words& words) {
    const std::filesystem::path path = std::filesystem::path(file_.name()).parent_path() / rest_of(words);
    std::error_code error;
    if (file_.memory() || !std::filesystem::is_regular_file(path, error)) {
      mesh_.warnings.push_back(file_.name() + ": no colours of materials; cannot find " + path.string());
      return;
    }
    read_materials(path, materials_);
  }

  void use(const std::string& material) {
    const auto found = materials_.find(material);
    color_.reset();
    if (found != materials_.end()) color_ = found->second;
    // Colours of triangles hide those of vertices.
    else if (!mesh_.triangle_colors.empty())
      color_ = k_no_color;
  }

  InputFile& file_;
  TextScanner scanner_;
  std::uint64_t& left_out_;
  const Progress& progress_;
  TriangleMesh mesh_;
  Materials materials_;
  std::optional<Rgb> color_;
  std::vector<std::uint32_t> polygon_;
};

}  // namespace

TriangleMesh read_obj_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress) {
  return ObjReader(file, left_out, progress).read();
}

}  // namespace alidade
