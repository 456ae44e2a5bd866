// SPDX-License-Identifier: MIT
#include "mesh/mesh_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/ray.h"
#include "base/text_scanner.h"
#include "base/words.h"
#include "cloud/ply/ply_header.h"
#include "cloud/point_table.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_rows_per_report = 1 << 14;

/// Most vertices and triangles of a mesh.
constexpr std::uint64_t k_most_mesh_parts = std::numeric_limits<std::uint32_t>::max();

/// Errors: less than `byte_count` of memory is free.
void check_free_memory(const std::string& file, std::uint64_t byte_count) {
  with_file(file, [&] { check_memory(byte_count, "this mesh"); });
}

/// Adds a polygon as a fan of triangles. Triangles with a vertex twice, and polygons of one or two vertices,
/// are not added but counted in `left_out`. Requires: the vertices exist. Errors: more than
/// k_most_mesh_parts triangles.
void add_fan(const std::string& file, std::span<const std::uint32_t> polygon, TriangleMesh& mesh,
             std::uint64_t& left_out) {
  if (polygon.size() < 3) ++left_out;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    if (mesh.triangles.size() >= k_most_mesh_parts)
      throw file_error(file, "too many triangles", fmt::format("at most {}", k_most_mesh_parts));
    const TriangleMesh::Triangle triangle{polygon[0], polygon[i - 1], polygon[i]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[0] == triangle[2])
      ++left_out;
    else
      mesh.triangles.push_back(triangle);
  }
}

/// Rows of an ascii file.
class TextRows {
 public:
  TextRows(InputFile& file, const PlyHeader& header)
      : scanner_(file, header.data_offset, header.line_count) {}

  void begin(const PlyElement& element) {
    if (!scanner_.next_words(words_))
      scanner_.fail("truncated file", "more lines of the element '" + element.name + "'");
    next_ = 0;
  }
  double value(ScalarType type) {
    if (next_ >= words_.size()) scanner_.fail("too few values");
    return require_cell(scanner_, words_[next_++], type).number;
  }
  /// Largest number of values of a list.
  std::uint64_t room(ScalarType /*type*/) const { return words_.size() - next_; }
  [[noreturn]] void fail(const std::string& problem, const std::string& expected,
                         const std::string& found) const {
    scanner_.fail(problem, expected, found);
  }
  std::uint64_t offset() const { return scanner_.offset(); }

 private:
  TextScanner scanner_;
  std::vector<std::string_view> words_;
  std::size_t next_ = 0;
};

/// Rows of a binary file.
class BinaryRows {
 public:
  BinaryRows(InputFile& file, const PlyHeader& header)
      : file_(file), cursor_(file, header.data_offset), order_(byte_order(header.format)) {}

  void begin(const PlyElement& /*element*/) { row_ = cursor_.offset(); }
  double value(ScalarType type) {
    return cell_from(cursor_.take(static_cast<std::size_t>(scalar_size(type))), type, order_).number;
  }
  std::uint64_t room(ScalarType type) const {
    return (file_.size() - cursor_.offset()) / static_cast<std::uint64_t>(scalar_size(type));
  }
  [[noreturn]] void fail(const std::string& problem, const std::string& expected,
                         const std::string& found) const {
    fail_at_byte(file_.name(), row_, problem, expected, found);
  }
  std::uint64_t offset() const { return cursor_.offset(); }

 private:
  InputFile& file_;
  ByteCursor cursor_;
  std::endian order_;
  std::uint64_t row_ = 0;
};

/// The meaning of a property.
enum class Part { x, y, z, red, green, blue, polygon, other };

Part part_of(const PlyProperty& property, bool is_vertex) {
  if (property.is_list) {
    const bool names_vertices = property.name == "vertex_indices" || property.name == "vertex_index";
    return !is_vertex && names_vertices ? Part::polygon : Part::other;
  }
  if (is_vertex && property.name == "x") return Part::x;
  if (is_vertex && property.name == "y") return Part::y;
  if (is_vertex && property.name == "z") return Part::z;
  if (property.name == "red" || property.name == "diffuse_red") return Part::red;
  if (property.name == "green" || property.name == "diffuse_green") return Part::green;
  if (property.name == "blue" || property.name == "diffuse_blue") return Part::blue;
  return Part::other;
}

/// Integers fill their type; others are 0 to 1.
float channel(double value, ScalarType type) {
  const double largest = type == ScalarType::uint8 ? 255.0 : type == ScalarType::uint16 ? 65535.0 : 1.0;
  return static_cast<float>(
      linear_from_srgb(std::isnan(value) ? 0.0 : std::clamp(value / largest, 0.0, 1.0)));
}

struct Row {
  glm::dvec3 position{0.0};
  Rgb color{0.0f};
  std::vector<std::uint32_t> polygon;
};

template <class Rows>
std::uint64_t list_length(Rows& rows, const PlyProperty& property) {
  const double count = rows.value(property.count_type);
  const std::uint64_t room = rows.room(property.type);
  if (!(count >= 0.0 && count <= static_cast<double>(room)))
    rows.fail("invalid list length of '" + property.name + "'", fmt::format("0 to {}", room),
              fmt::format("{:.0f}", count));
  return static_cast<std::uint64_t>(count);
}

class PlyMeshReader {
 public:
  PlyMeshReader(InputFile& file, PlyHeader header, std::uint64_t& left_out, const Progress& progress)
      : file_(file), header_(std::move(header)), left_out_(left_out), progress_(progress) {}

  TriangleMesh read() {
    header_.format == PlyFormat::ascii ? read_elements(TextRows(file_, header_))
                                       : read_elements(BinaryRows(file_, header_));
    // If there are several elements named face, some may lack colours.
    if (!mesh_.triangle_colors.empty()) mesh_.triangle_colors.resize(mesh_.triangles.size(), Rgb(0.5f));
    return std::move(mesh_);
  }

 private:
  const PlyElement& vertex() const { return header_.elements[header_.vertex]; }

  /// Errors: more rows than the file has bytes for; more than a mesh may have.
  void check_room(const PlyElement& element, std::uint64_t bytes_in_memory) const {
    const bool is_text = header_.format == PlyFormat::ascii;
    const std::uint64_t size = is_text ? 2 * element.properties.size() : element.smallest_size();
    const std::uint64_t left = file_.size() - header_.data_offset;
    if (element.count == 0) return;
    // The end of the last line may be missing.
    if (size == 0 || element.count > (left + 1) / size)
      throw file_error(file_.name(), "truncated file: too short for its element '" + element.name + "'",
                       fmt::format("{} of at least {} bytes", element.count, size),
                       fmt::format("{} bytes", left));
    if (element.count > k_most_mesh_parts)
      throw file_error(file_.name(), "too many of the element '" + element.name + "'",
                       fmt::format("at most {}", k_most_mesh_parts), std::to_string(element.count));
    check_free_memory(file_.name(), element.count * bytes_in_memory);
  }

  template <class Rows>
  void read_elements(Rows rows) {
    for (const PlyElement& element : header_.elements) {
      const bool is_vertex = &element == &vertex(), is_face = element.name == "face";
      // An element without properties has no bytes to read, but its count may be huge.
      if (element.properties.empty()) continue;
      if (is_vertex || is_face)
        read_element(rows, element, is_vertex);
      else
        skip(rows, element);
    }
  }

  template <class Rows>
  void read_element(Rows& rows, const PlyElement& element, bool is_vertex) {
    std::vector<Part> parts;
    for (const PlyProperty& property : element.properties) parts.push_back(part_of(property, is_vertex));
    const auto has = [&](Part part) { return std::ranges::find(parts, part) != parts.end(); };
    if (is_vertex && !(has(Part::x) && has(Part::y) && has(Part::z)))
      throw file_error(file_.name(), "vertices without coordinates", "the properties x, y and z");
    if (!is_vertex && !has(Part::polygon))
      throw file_error(file_.name(), "faces without vertices", "the list vertex_indices or vertex_index");
    const bool has_color = has(Part::red) && has(Part::green) && has(Part::blue);
    check_room(element, is_vertex ? sizeof(glm::dvec3) + has_color * sizeof(Rgb)
                                  : sizeof(TriangleMesh::Triangle) + has_color * sizeof(Rgb));
    if (is_vertex)
      mesh_.vertices.reserve(element.count);
    else
      mesh_.triangles.reserve(mesh_.triangles.size() + element.count);
    if (has_color && is_vertex) mesh_.vertex_colors.reserve(element.count);
    Row row;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (i % k_rows_per_report == 0) report(progress_, rows.offset(), file_.size());
      rows.begin(element);
      fill(rows, element, parts, row);
      if (is_vertex) {
        mesh_.vertices.push_back(row.position);
        if (has_color) mesh_.vertex_colors.push_back(row.color);
      } else {
        add_fan(file_.name(), row.polygon, mesh_, left_out_);
        if (has_color) mesh_.triangle_colors.resize(mesh_.triangles.size(), row.color);
      }
    }
  }

  template <class Rows>
  void fill(Rows& rows, const PlyElement& element, const std::vector<Part>& parts, Row& row) {
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (parts[p] == Part::polygon) {
        fill_polygon(rows, property, row.polygon);
      } else if (property.is_list) {
        skip_list(rows, property);
      } else {
        const double value = rows.value(property.type);
        const int part = static_cast<int>(parts[p]);
        if (part < 3)
          row.position[part] = value;
        else if (part < 6)
          row.color[part - 3] = channel(value, property.type);
      }
    }
  }

  template <class Rows>
  void fill_polygon(Rows& rows, const PlyProperty& property, std::vector<std::uint32_t>& polygon) {
    const std::uint64_t count = list_length(rows, property);
    polygon.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      const double number = rows.value(property.type);
      if (!(number >= 0.0 && number < static_cast<double>(vertex().count)) || number != std::floor(number))
        rows.fail("a face names a vertex that does not exist",
                  fmt::format("numbers from 0 to below {}", vertex().count), fmt::format("{:.17g}", number));
      polygon.push_back(static_cast<std::uint32_t>(number));
    }
  }

  template <class Rows>
  static void skip_list(Rows& rows, const PlyProperty& property) {
    for (std::uint64_t left = list_length(rows, property); left > 0; --left) rows.value(property.type);
  }

  template <class Rows>
  void skip(Rows& rows, const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (i % k_rows_per_report == 0) report(progress_, rows.offset(), file_.size());
      rows.begin(element);
      for (const PlyProperty& property : element.properties)
        property.is_list ? skip_list(rows, property) : static_cast<void>(rows.value(property.type));
    }
  }

  InputFile& file_;
  PlyHeader header_;
  std::uint64_t& left_out_;
  const Progress& progress_;
  TriangleMesh mesh_;
};

// OBJ and MTL. Source: Wavefront Technologies, Object Files (.obj), Advanced Visualizer manual, appendix B1.

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
      if (line % k_rows_per_report == 0) report(progress_, scanner_.offset(), file_.size());
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

TriangleMesh read_ply_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress) {
  // Its check of the room names an option that is for clouds alone.
  return PlyMeshReader(file, read_ply_header(file, Damage::read_over), left_out, progress).read();
}

TriangleMesh read_obj_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress) {
  return ObjReader(file, left_out, progress).read();
}

}  // namespace alidade
