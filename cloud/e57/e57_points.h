// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud/attributes.h"
#include "cloud/e57/e57_file.h"

namespace alidade {

/// Numbers of one width that arrive as bytes in arbitrary pieces: the i-th takes bits i * width and up, bit k
/// of the stream is bit k mod 8 of byte k / 8. Memory: the bytes added and not yet taken.
class BitQueue {
 public:
  /// Width is 0 to 64 bits. With width 0, any number of zeros is always available.
  explicit BitQueue(int width) : width_(width) {}

  void add(std::span<const std::byte> piece);
  /// Makes the next piece begin with a new number, in a byte of its own. Drops the unused bits of the last
  /// number or, for numbers narrower than a byte, the rest of the last byte. Returns false if whole numbers
  /// are still waiting before these bits, so that they cannot be padding.
  bool restart();
  /// How many whole numbers can be taken, up to `most`.
  std::size_t available(std::size_t most) const;
  /// Takes the next numbers. Requires that as many are available.
  void take(std::span<std::uint64_t> numbers);

 private:
  std::uint64_t bit_count() const { return 8 * std::uint64_t{bytes_.size()} - next_bit_; }

  int width_;
  std::vector<std::byte> bytes_;
  std::uint64_t next_bit_ = 0;  ///< of bytes_
};

/// Reads the records of a scan, some thousand at a time. Streams of fields that are not requested are not
/// decoded. Memory: a block, and the bytes by which one stream of the scan is ahead of another.
class E57Records {
 public:
  /// Takes columns of values: columns[i] belongs to the i-th requested field.
  using Visitor = std::function<void(std::span<const std::vector<double>> columns, std::size_t count)>;

  /// `wanted` are fields of the scan, ascending, none of them text; `where` is the scan's name in messages.
  /// Requires a scan of an E57File over `pages`.
  E57Records(E57Pages& pages, const E57Scan& scan, std::string where, std::span<const std::size_t> wanted);

  /// Passes all records to `visitor` in order. Errors, with scan and packet, counted from 1: an invalid
  /// packet or one that exceeds the section, another number of streams than the scan has fields, a section
  /// that ends before all records were read; a damaged page.
  void visit(const Visitor& visitor);

 private:
  struct Stream {
    std::size_t field;
    BitQueue queue;
  };

  bool next_packet();
  void take_pieces(std::span<const std::byte> packet);
  void decode(const Stream& stream, std::span<const std::uint64_t> numbers, std::span<double> values) const;
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;

  E57Pages& pages_;
  const E57Scan& scan_;
  std::string where_;
  std::vector<Stream> streams_;
  std::uint64_t offset_;      ///< of the next packet
  std::uint64_t packet_ = 0;  ///< number of the last packet, from 1
};

/// The meaning of a field of a scan.
enum class E57Role : std::uint8_t {
  x,
  y,
  z,
  range,
  azimuth,
  elevation,
  cartesian_state,
  spherical_state,
  intensity,
  intensity_invalid,
  red,
  green,
  blue,
  color_invalid,
  row,
  column,
  return_index,
  return_count,
  time,
  time_invalid,
  normal_x,
  normal_y,
  normal_z,
};
inline constexpr std::size_t k_e57_role_count = 23;

/// The field of a scan for each role; empty where the scan has none. Of roles that are meaningful only
/// together (coordinates, colours, normals), all have a field or none has.
class E57Roles {
 public:
  /// Names are those of the standard; those of normals are of its extensions, under any prefix. Text fields
  /// have no role.
  explicit E57Roles(const E57Scan& scan);

  std::optional<std::size_t> field(E57Role role) const { return fields_[static_cast<std::size_t>(role)]; }
  bool has(E57Role role) const { return field(role).has_value(); }
  bool has_cartesian() const { return has(E57Role::x); }
  bool has_spherical() const { return has(E57Role::range); }

  /// The attributes that these fields fill.
  AttributeSet attributes() const;

  /// The fields that positions need, and those of `attributes`, ascending.
  std::vector<std::size_t> fields_for(AttributeSet attributes) const;

  /// Names of fields without a role.
  const std::vector<std::string>& unread() const { return unread_; }

 private:
  std::array<std::optional<std::size_t>, k_e57_role_count> fields_{};
  std::vector<std::string> unread_;
};

/// Numbers of points of a scan that do not become points of the cloud.
struct E57LeftOut {
  std::uint64_t directions = 0;  ///< only the direction is known (state 1)
  std::uint64_t unknown = 0;     ///< nothing is known (state 2)
  std::uint64_t not_finite = 0;  ///< a coordinate is not a finite number, or an angle is beyond 2^30

  std::uint64_t total() const { return directions + unknown + not_finite; }
};

/// Some thousand points of a scan, in the axes of the file.
struct E57Points {
  std::span<const glm::dvec3> positions;                  ///< NaN for points that are left out
  std::array<const double*, k_e57_role_count> columns{};  ///< null where the scan has no such field

  bool has(E57Role role) const { return columns[static_cast<std::size_t>(role)] != nullptr; }
  /// Requires has(role).
  double value(E57Role role, std::size_t i) const { return columns[static_cast<std::size_t>(role)][i]; }
  /// Whether the scan has a flag and it is set. Some writers store flags as floats; NaN counts as set.
  bool is_flagged(E57Role flag, std::size_t i) const {
    return has(flag) && !(std::abs(value(flag, i)) < 0.5);
  }
  bool is_left_out(std::size_t i) const { return positions[i].x != positions[i].x; }
};

/// Positions of a scan's points: Cartesian ones where they are valid, else those from spherical coordinates,
///   x = r cos(elevation) cos(azimuth), y = r cos(elevation) sin(azimuth), z = r sin(elevation),
/// transformed to the axes of the file by the scan's pose. The result has the same bits on every machine.
class E57PointReader {
 public:
  /// Requires a scan with coordinates of one kind or both.
  E57PointReader(const E57Scan& scan, const E57Roles& roles) : scan_(scan), roles_(roles) {}

  /// Passes all points, with the fields of `attributes`, to `visitor`. Errors: those of E57Records.
  void visit(E57Pages& pages, const std::string& where, AttributeSet attributes,
             const std::function<void(const E57Points&)>& visitor);

  /// The points left out by the last visit().
  const E57LeftOut& left_out() const { return left_out_; }

  /// The resolution of the points' stored coordinates in the last visit(), per axis of the file: half an ulp
  /// of the largest float32, half a step of integers, 0 for float64. Where integers are not on a lattice of
  /// decimal steps around whole numbers (other scales, rotated or spherical scans), a twentieth of a step, so
  /// that rounding keeps them distinct. Angles are multiplied by the largest distance.
  glm::dvec3 resolution() const;

 private:
  glm::dvec3 position_of(const E57Points& points, std::size_t i);
  double resolution_of(E57Role role, double largest, bool may_be_exact, double translation) const;

  const E57Scan& scan_;
  const E57Roles& roles_;
  E57LeftOut left_out_;
  glm::dvec3 largest_{0.0};  ///< |coordinate| as stored, of Cartesian points
  double reach_ = 0.0;       ///< largest distance of points from spherical coordinates
  bool met_cartesian_ = false, met_spherical_ = false;
};

}  // namespace alidade
