// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_points.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "base/exact_math.h"
#include "base/ray.h"
#include "cloud/point_table.h"

namespace alidade {
namespace {

/// The `width` bits from bit `shift` (0 to 7) of the nine bytes at `at`.
std::uint64_t bits_at(const std::byte* at, unsigned shift, unsigned width) {
  std::uint64_t value = load<std::uint64_t>(at) >> shift;
  if (shift + width > 64) value |= load<std::uint8_t>(at + 8) * (std::uint64_t{1} << (64 - shift));
  return width == 64 ? value : value & ((std::uint64_t{1} << width) - 1);
}

constexpr std::size_t k_block = 4096;
constexpr unsigned k_data_packet = 1, k_empty_packet = 2;  // 0: index
constexpr std::size_t k_data_header = 6;

struct NamedRole {
  std::string_view name;
  std::optional<Attribute> attribute;  ///< empty for fields of positions
};

/// In the order of E57Role.
constexpr std::array<NamedRole, k_e57_role_count> k_roles = {{
    {"cartesianX", {}},
    {"cartesianY", {}},
    {"cartesianZ", {}},
    {"sphericalRange", {}},
    {"sphericalAzimuth", {}},
    {"sphericalElevation", {}},
    {"cartesianInvalidState", {}},
    {"sphericalInvalidState", {}},
    {"intensity", Attribute::intensity},
    {"isIntensityInvalid", Attribute::intensity},
    {"colorRed", Attribute::color},
    {"colorGreen", Attribute::color},
    {"colorBlue", Attribute::color},
    {"isColorInvalid", Attribute::color},
    {"rowIndex", Attribute::extra_dimensions},
    {"columnIndex", Attribute::extra_dimensions},
    {"returnIndex", Attribute::returns},
    {"returnCount", Attribute::returns},
    {"timeStamp", Attribute::gps_time},
    {"isTimeStampInvalid", Attribute::gps_time},
    {"normalX", Attribute::normal},
    {"normalY", Attribute::normal},
    {"normalZ", Attribute::normal},
}};

constexpr std::size_t index_of(E57Role role) {
  return static_cast<std::size_t>(role);
}

/// The role of a field by its name; k_e57_role_count for none.
std::size_t role_of(const E57Field& field) {
  constexpr std::size_t k_first_of_extensions = index_of(E57Role::normal_x);
  if (field.kind == E57FieldKind::text) return k_e57_role_count;
  const std::size_t colon = field.name.rfind(':');
  const bool is_extension = colon != std::string::npos;
  const std::string_view name = std::string_view(field.name).substr(is_extension ? colon + 1 : 0);
  for (std::size_t role = is_extension ? k_first_of_extensions : 0; role < k_roles.size(); ++role) {
    if (k_roles[role].name == name) return role;
  }
  return k_e57_role_count;
}

/// Roles that require each other.
constexpr std::array<std::array<E57Role, 3>, 4> k_triples = {
    {{E57Role::x, E57Role::y, E57Role::z},
     {E57Role::range, E57Role::azimuth, E57Role::elevation},
     {E57Role::red, E57Role::green, E57Role::blue},
     {E57Role::normal_x, E57Role::normal_y, E57Role::normal_z}}};

/// Flags and the roles that they apply to.
constexpr std::array<std::array<E57Role, 2>, 5> k_flags = {{{E57Role::cartesian_state, E57Role::x},
                                                            {E57Role::spherical_state, E57Role::range},
                                                            {E57Role::intensity_invalid, E57Role::intensity},
                                                            {E57Role::color_invalid, E57Role::red},
                                                            {E57Role::time_invalid, E57Role::time}}};

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double k_largest_angle = 1 << 30;

/// The state of a point: 0, 1, or 2 for all other values. Some writers store states as floats.
int state_of(const E57Points& points, E57Role role, std::size_t i) {
  if (!points.has(role)) return 0;
  const double state = points.value(role, i);
  return std::abs(state) < 0.5 ? 0 : std::abs(state - 1.0) < 0.5 ? 1 : 2;
}

/// The position of spherical coordinates: see E57PointReader.
glm::dvec3 from_spherical(double range, double azimuth, double elevation) {
  if (!(std::abs(azimuth) < k_largest_angle && std::abs(elevation) < k_largest_angle))
    return glm::dvec3(k_nan);
  const SineCosine a = sine_cosine(azimuth), e = sine_cosine(elevation);
  return {range * e.cosine * a.cosine, range * e.cosine * a.sine, range * e.sine};
}

/// A position of a scan in the axes of the file. Sums in a fixed order, so that compilers agree.
glm::dvec3 to_file(const E57Pose& pose, const glm::dvec3& position) {
  if (!pose.is_rotated) return position + pose.translation;
  glm::dvec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    result[axis] = pose.rotation[0][axis] * position.x + pose.rotation[1][axis] * position.y +
                   pose.rotation[2][axis] * position.z + pose.translation[axis];
  }
  return result;
}

/// Whether offset + scale * integer is on the lattice that fit_lattice() makes for this scale.
bool is_decimal(double scale, double offset) {
  const double exponent = std::nearbyint(std::log10(scale));
  return scale <= 1.0 && std::abs(scale / std::pow(10.0, exponent) - 1.0) < 1e-9 &&
         std::abs(offset / scale - std::nearbyint(offset / scale)) < 1e-6;
}

}  // namespace

void BitQueue::add(std::span<const std::byte> piece) {
  const std::size_t used = static_cast<std::size_t>(next_bit_ / 8);
  // The cost is linear, as the rest is moved only when at least as many bytes were used.
  if (used > 0 && used >= bytes_.size() - used) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(used));
    next_bit_ %= 8;
  }
  bytes_.insert(bytes_.end(), piece.begin(), piece.end());
}

bool BitQueue::restart() {
  if (width_ == 0) return true;
  // The padding of a byte looks like further numbers if these are narrow.
  const bool is_filling = width_ < 8 && bit_count() < 8;
  if (available(1) > 0 && !is_filling)
    return width_ >= 8 && bit_count() % static_cast<std::uint64_t>(width_) == 0;
  bytes_.clear();
  next_bit_ = 0;
  return true;
}

std::size_t BitQueue::available(std::size_t most) const {
  if (width_ == 0) return most;
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(bit_count() / static_cast<std::uint64_t>(width_), most));
}

void BitQueue::take(std::span<std::uint64_t> numbers) {
  if (width_ == 0) {
    std::ranges::fill(numbers, 0);
    return;
  }
  const unsigned width = static_cast<unsigned>(width_);
  for (std::uint64_t& number : numbers) {
    const std::size_t byte = static_cast<std::size_t>(next_bit_ / 8);
    const unsigned shift = static_cast<unsigned>(next_bit_ % 8);
    if (bytes_.size() - byte >= 9) {
      number = bits_at(bytes_.data() + byte, shift, width);
    } else {
      std::array<std::byte, 9> last{};
      std::memcpy(last.data(), bytes_.data() + byte, bytes_.size() - byte);
      number = bits_at(last.data(), shift, width);
    }
    next_bit_ += width;
  }
}

E57Records::E57Records(E57Pages& pages, const E57Scan& scan, std::string where,
                       std::span<const std::size_t> wanted)
    : pages_(pages), scan_(scan), where_(std::move(where)), offset_(scan.first_packet) {
  for (const std::size_t field : wanted) streams_.push_back({field, BitQueue(scan.fields[field].bits())});
}

void E57Records::visit(const Visitor& visitor) {
  std::vector<std::vector<double>> columns(streams_.size(), std::vector<double>(k_block));
  std::vector<std::uint64_t> numbers(k_block);
  for (std::uint64_t done = 0; done < scan_.record_count;) {
    std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(scan_.record_count - done, k_block));
    for (const Stream& stream : streams_) count = stream.queue.available(count);
    if (count == 0) {
      if (next_packet()) continue;
      fail("truncated section", fmt::format("{} records", scan_.record_count), std::to_string(done));
    }
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      const std::span<std::uint64_t> taken = std::span(numbers).first(count);
      streams_[i].queue.take(taken);
      decode(streams_[i], taken, columns[i]);
    }
    visitor(columns, count);
    done += count;
  }
}

/// Reads the next packet; false at the end of the section.
bool E57Records::next_packet() {
  constexpr std::size_t k_smallest = 4;
  const std::uint64_t left = scan_.end - offset_;
  if (left == 0) return false;
  ++packet_;
  if (left < k_smallest) fail("the section ends inside a packet", "at least 4 bytes", std::to_string(left));
  const std::span<const std::byte> head = pages_.view(offset_, k_smallest);
  const unsigned kind = load<std::uint8_t>(head.data());
  const std::size_t length = load<std::uint16_t>(head.data() + 2) + std::size_t{1};
  if (kind > k_empty_packet) fail("unknown packet type", "0, 1 or 2", std::to_string(kind));
  if (length % 4 != 0) fail("invalid packet length", "a multiple of 4", std::to_string(length));
  if (length > left)
    fail("the packet exceeds its section", fmt::format("at most {} bytes", left), std::to_string(length));
  if (kind == k_data_packet) take_pieces(pages_.view(offset_, length));
  offset_ += length;
  return true;
}

void E57Records::take_pieces(std::span<const std::byte> packet) {
  if (packet.size() < k_data_header)
    fail("the packet is too short", fmt::format("at least {} bytes", k_data_header),
         std::to_string(packet.size()));
  const bool restarts = (load<std::uint8_t>(packet.data() + 1) & 1) != 0;
  const std::size_t count = load<std::uint16_t>(packet.data() + 4);
  if (count != scan_.fields.size()) {
    fail("wrong number of streams", std::to_string(scan_.fields.size()), std::to_string(count));
  }
  if (packet.size() < k_data_header + 2 * count) {
    fail("the packet is too short for its streams",
         fmt::format("at least {} bytes", k_data_header + 2 * count), std::to_string(packet.size()));
  }
  std::size_t begin = k_data_header + 2 * count;
  auto stream = streams_.begin();
  for (std::size_t field = 0; field < count; ++field) {
    const std::size_t length = load<std::uint16_t>(packet.data() + k_data_header + 2 * field);
    if (length > packet.size() - begin) {
      fail("the packet is too short for its stream of " + scan_.fields[field].name,
           fmt::format("at most {} bytes", packet.size() - begin), std::to_string(length));
    }
    if (stream != streams_.end() && stream->field == field) {
      if (restarts && !stream->queue.restart())
        fail("unexpected compressor restart inside the records of " + scan_.fields[field].name);
      stream->queue.add(packet.subspan(begin, length));
      ++stream;
    }
    begin += length;
  }
}

void E57Records::decode(const Stream& stream, std::span<const std::uint64_t> numbers,
                        std::span<double> values) const {
  const E57Field& field = scan_.fields[stream.field];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (field.kind == E57FieldKind::float64) {
      values[i] = std::bit_cast<double>(numbers[i]);
    } else if (field.kind == E57FieldKind::float32) {
      values[i] = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(numbers[i])));
    } else {
      // Unsigned, because codes above the maximum may exceed 64 bits.
      const auto stored = static_cast<std::int64_t>(static_cast<std::uint64_t>(field.minimum) + numbers[i]);
      values[i] = static_cast<double>(stored) * field.scale + field.offset;
    }
  }
}

void E57Records::fail(std::string problem, std::string expected, std::string found) const {
  pages_.fail(fmt::format("{}, packet {}", where_, packet_), std::move(problem), std::move(expected),
              std::move(found));
}

E57Roles::E57Roles(const E57Scan& scan) {
  for (std::size_t i = 0; i < scan.fields.size(); ++i) {
    const std::size_t role = role_of(scan.fields[i]);
    if (role < k_e57_role_count && !fields_[role]) fields_[role] = i;
  }
  for (const auto& triple : k_triples) {
    const bool complete = std::ranges::all_of(triple, [&](E57Role role) { return has(role); });
    for (const E57Role role : triple) {
      if (!complete) fields_[index_of(role)].reset();
    }
  }
  for (const auto& [flag, subject] : k_flags) {
    if (!has(subject)) fields_[index_of(flag)].reset();
  }
  for (std::size_t i = 0; i < scan.fields.size(); ++i) {
    if (std::ranges::find(fields_, std::optional(i)) == fields_.end()) unread_.push_back(scan.fields[i].name);
  }
}

AttributeSet E57Roles::attributes() const {
  AttributeSet set;
  for (std::size_t role = 0; role < k_roles.size(); ++role) {
    if (fields_[role] && k_roles[role].attribute) set = set | *k_roles[role].attribute;
  }
  return set;
}

std::vector<std::size_t> E57Roles::fields_for(AttributeSet attributes) const {
  std::vector<std::size_t> fields;
  for (std::size_t role = 0; role < k_roles.size(); ++role) {
    const auto& attribute = k_roles[role].attribute;
    if (fields_[role] && (!attribute || attributes.contains(*attribute))) fields.push_back(*fields_[role]);
  }
  std::ranges::sort(fields);
  return fields;
}

void E57PointReader::visit(E57Pages& pages, const std::string& where, AttributeSet attributes,
                           const std::function<void(const E57Points&)>& visitor) {
  left_out_ = {};
  const std::vector<std::size_t> fields = roles_.fields_for(attributes);
  std::vector<glm::dvec3> positions;
  E57Records records(pages, scan_, where, fields);
  records.visit([&](std::span<const std::vector<double>> columns, std::size_t count) {
    E57Points points;
    for (std::size_t role = 0; role < k_e57_role_count; ++role) {
      const auto field = roles_.field(static_cast<E57Role>(role));
      const auto found = field ? std::ranges::find(fields, *field) : fields.end();
      if (found != fields.end())
        points.columns[role] = columns[static_cast<std::size_t>(found - fields.begin())].data();
    }
    positions.resize(count);
    for (std::size_t i = 0; i < count; ++i) positions[i] = position_of(points, i);
    points.positions = positions;
    visitor(points);
  });
}

glm::dvec3 E57PointReader::position_of(const E57Points& points, std::size_t i) {
  const int cartesian = roles_.has_cartesian() ? state_of(points, E57Role::cartesian_state, i) : 2;
  const int spherical = roles_.has_spherical() ? state_of(points, E57Role::spherical_state, i) : 2;
  glm::dvec3 position(k_nan);
  if (cartesian == 0) {
    position = {points.value(E57Role::x, i), points.value(E57Role::y, i), points.value(E57Role::z, i)};
  } else if (spherical == 0) {
    position = from_spherical(points.value(E57Role::range, i), points.value(E57Role::azimuth, i),
                              points.value(E57Role::elevation, i));
  } else {
    ++(cartesian == 1 || spherical == 1 ? left_out_.directions : left_out_.unknown);
    return position;
  }
  const glm::dvec3 world = scan_.pose ? to_file(*scan_.pose, position) : position;
  if (!is_finite(world)) {
    ++left_out_.not_finite;
    return glm::dvec3(k_nan);
  }
  if (cartesian == 0) {
    met_cartesian_ = true;
    for (int axis = 0; axis < 3; ++axis) largest_[axis] = std::max(largest_[axis], std::abs(position[axis]));
  } else {
    met_spherical_ = true;
    reach_ = std::max(reach_, std::abs(points.value(E57Role::range, i)));
  }
  return world;
}

double E57PointReader::resolution_of(E57Role role, double largest, bool may_be_exact,
                                     double translation) const {
  const E57Field& field = scan_.fields[*roles_.field(role)];
  switch (field.kind) {
    case E57FieldKind::float32:
      // Zeros have no resolution.
      return largest == 0.0 ? 0.0 : type_resolution(ScalarType::float32, largest);
    case E57FieldKind::integer:
    case E57FieldKind::scaled_integer: {
      const double step = std::abs(field.scale);
      return (may_be_exact && is_decimal(step, field.offset + translation) ? 0.5 : 0.05) * step;
    }
    default:
      return 0.0;
  }
}

glm::dvec3 E57PointReader::resolution() const {
  constexpr E57Role k_axes[] = {E57Role::x, E57Role::y, E57Role::z};
  glm::dvec3 resolution(std::numeric_limits<double>::infinity());
  if (met_cartesian_) {
    const bool is_rotated = scan_.pose && scan_.pose->is_rotated;
    for (int axis = 0; axis < 3; ++axis) {
      const double translation = scan_.pose ? scan_.pose->translation[axis] : 0.0;
      resolution[axis] = resolution_of(k_axes[axis], largest_[axis], !is_rotated, translation);
    }
    if (is_rotated) resolution = glm::dvec3(std::min({resolution.x, resolution.y, resolution.z}));
  }
  if (met_spherical_) {
    const double finest =
        std::min({resolution_of(E57Role::range, reach_, false, 0.0),
                  resolution_of(E57Role::azimuth, std::numbers::pi, false, 0.0) * reach_,
                  resolution_of(E57Role::elevation, std::numbers::pi, false, 0.0) * reach_});
    for (int axis = 0; axis < 3; ++axis) resolution[axis] = std::min(resolution[axis], finest);
  }
  return resolution;
}

}  // namespace alidade
