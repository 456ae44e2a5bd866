// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>

#include "octree/index_file.h"
#include "octree/node.h"
#include "octree/query.h"
#include "octree/tree_walk.h"
#include "tests/octree/index_test_support.h"
#include "tests/support/point_families.h"
#include "tests/support/seal_index.h"

namespace alidade {
namespace {

using test::error_of;
using test::get;
using test::put;
using test::seal;
using test::seal_header;
using test::SectionRow;

using Bytes = std::vector<std::byte>;

PointCloud cloud_with_everything() {
  test::Random random("index damage");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 1500; ++i) positions.push_back(glm::dvec3(20, 20, 2) * random.in_cube());
  // Far strays have exact positions beside their coordinates.
  for (int i = 0; i < 8; ++i) positions.push_back(2e6 * random.in_cube());
  PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  test::fill_everything(cloud, random);
  return cloud;
}

/// The bytes of a sound index file.
const Bytes& sound_file() {
  static const Bytes bytes = [] {
    const auto path = test::test_folder() / "sound.alidade";
    const PointCloud cloud = cloud_with_everything();
    save_index(path, build(cloud), cloud);
    return test::read_bytes(path);
  }();
  return bytes;
}

SectionRow section(const Bytes& file, IndexSection kind) {
  for (const SectionRow& row : test::section_rows(file))
    if (row.kind == static_cast<std::uint32_t>(kind)) return row;
  ADD_FAILURE() << "no section " << name(kind);
  return {};
}

/// Does with a file what programs do: asks it, and looks up attributes by the ids of the answers.
void use(const IndexFile& index) {
  const Octree octree = index.octree();
  const AttributeColumns& columns = index.columns();
  test::Random random("use");
  std::uint64_t sum = 0;
  const auto look_up = [&](const std::optional<Hit>& hit) {
    if (!hit) return;
    ASSERT_LT(hit->point_id, octree.size());
    if (!columns.colors.empty()) sum += columns.colors[hit->point_id].x;
    if (!columns.normals.empty()) sum += columns.normals[hit->point_id].x > 0;
  };
  std::vector<Ray> rays;
  for (int i = 0; i < 6; ++i) rays.push_back(make_ray(30.0 * random.in_cube(), random.direction()));
  for (const Ray& ray : rays) {
    for (const Measure measure : {Measure::t, Measure::entry})
      look_up(closest(octree, ray, {.radius = 0.3, .measure = measure}));
    for (const Hit& hit : find(octree, ray, {.radius = 5.0, .measure = Measure::distance, .k = 4}))
      look_up(hit);
    sum += occluded(octree, ray, {.radius = 0.05});
    const bool is_layered = octree.view().organisation == Organisation::layered;
    sum += count(octree, ray, {.radius = 2.0, .max_level = is_layered ? 1 : k_all_levels});
  }
  std::vector<std::optional<Hit>> hits(rays.size());
  closest(octree, rays, {.radius = 1.0}, hits);
  for (const std::optional<Hit>& hit : hits) look_up(hit);
  Bounds box, everywhere;
  box.grow(glm::dvec3(-5.0));
  box.grow(glm::dvec3(5.0));
  everywhere.grow(glm::dvec3(-1e9));
  everywhere.grow(glm::dvec3(1e9));
  sum += count(octree, box, {}) + count(octree, everywhere, {});
  for (const PointHit& hit : find(octree, box, {})) ASSERT_LT(hit.point_id, octree.size());
  for (const PointHit& hit : find(octree, glm::dvec3(1.0), {.k = 8})) ASSERT_LT(hit.point_id, octree.size());
  sum += static_cast<std::uint64_t>(positions_in_order(octree.view()).size());
  sum += index.records().size();
  EXPECT_GE(sum, 0u);
}

/// Whether a file is refused; if not, everything that can be done with it is done.
bool is_refused(const Bytes& bytes) {
  try {
    const IndexFile index = test::index_in_memory(bytes);
    use(index);
    std::vector<InputFile> files;
    files.emplace_back(bytes, "memory");
    join_files(std::move(files), {});
    return false;
  } catch (const Error& error) {
    EXPECT_EQ(error.parts().file, "memory");
    return true;
  }
}

bool is_refused_when_opened(const Bytes& bytes) {
  try {
    test::index_in_memory(bytes);
    return false;
  } catch (const Error&) {
    return true;
  }
}

bool is_refused_when_verified(const Bytes& bytes) {
  try {
    test::index_in_memory(bytes).verify();
    return false;
  } catch (const Error&) {
    return true;
  }
}

TEST(IndexDamage, a_sound_file_is_not_refused) {
  Bytes file = sound_file();
  EXPECT_FALSE(is_refused(file));
  EXPECT_FALSE(is_refused_when_verified(file));
  // And sealing it again changes nothing, so that the tests below test what they say.
  seal(file);
  EXPECT_EQ(file, sound_file());
}

TEST(IndexDamage, a_file_cut_off_anywhere_is_an_error_when_opened) {
  const Bytes& file = sound_file();
  std::vector<std::size_t> lengths = {0, 1, 7, 8, 9, 255, 256, 4095, 4096, 4097, file.size() - 1};
  for (const SectionRow& row : test::section_rows(file)) {
    for (const std::uint64_t place : {row.place, row.place + row.bytes}) {
      for (const int step : {-1, 0, 1}) lengths.push_back(static_cast<std::size_t>(place) + step);
    }
  }
  test::Random random;
  for (int i = 0; i < 300; ++i) lengths.push_back(random.below(file.size()));
  for (const std::size_t length : lengths) {
    if (length >= file.size()) continue;
    EXPECT_TRUE(
        is_refused_when_opened(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length))))
        << length;
  }
}

TEST(IndexDamage, bytes_behind_the_end_are_an_error_when_opened) {
  Bytes file = sound_file();
  file.push_back(std::byte{0});
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("too long"), std::string::npos);
}

TEST(IndexDamage, a_flipped_bit_in_any_byte_of_the_header_is_an_error_when_opened) {
  Bytes file = sound_file();
  for (std::size_t place = 0; place < 4096; ++place) {
    const std::byte mask{static_cast<unsigned char>(1u << place % 8)};
    file[place] ^= mask;
    EXPECT_TRUE(is_refused_when_opened(file)) << place;
    file[place] ^= mask;
  }
}

TEST(IndexDamage, a_flipped_bit_anywhere_is_found_by_verifying_and_does_no_harm_without) {
  Bytes file = sound_file();
  test::Random random;
  for (int i = 0; i < 1500; ++i) {
    const std::size_t place = random.below(file.size());
    const std::byte mask{static_cast<unsigned char>(1u << random.below(8))};
    file[place] ^= mask;
    EXPECT_TRUE(is_refused_when_verified(file)) << place;
    is_refused(file);
    file[place] ^= mask;
  }
}

TEST(IndexDamage, a_flipped_bit_in_nodes_or_ids_is_an_error_before_the_first_query) {
  Bytes file = sound_file();
  test::Random random;
  for (const IndexSection kind : {IndexSection::nodes, IndexSection::ids}) {
    const SectionRow row = section(file, kind);
    for (int i = 0; i < 100; ++i) {
      const std::size_t place = row.place + random.below(row.bytes);
      file[place] ^= std::byte{4};
      const IndexFile index = test::index_in_memory(file);
      const std::string message = error_of([&] { index.octree(); });
      EXPECT_NE(message.find("section " + name(kind) + " is damaged"), std::string::npos) << message;
      EXPECT_NE(message.find("memory:byte " + std::to_string(row.place)), std::string::npos) << message;
      file[place] ^= std::byte{4};
    }
  }
}

TEST(IndexDamage, a_flipped_bit_in_the_metadata_is_an_error_when_opened) {
  Bytes file = sound_file();
  const SectionRow row = section(file, IndexSection::metadata);
  for (std::uint64_t place = row.place; place < row.place + row.bytes; ++place) {
    file[place] ^= std::byte{1};
    EXPECT_TRUE(is_refused_when_opened(file)) << place;
    file[place] ^= std::byte{1};
  }
}

TEST(IndexDamage, another_byte_order_a_future_version_and_another_file_are_told_apart) {
  Bytes file = sound_file();
  put<std::uint32_t>(file, 8, 0x04030201);
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("other byte order"), std::string::npos);
  file = sound_file();
  put<std::uint32_t>(file, 12, 2);
  const std::string message = error_of([&] { test::index_in_memory(file); });
  EXPECT_NE(message.find("a version that this program does not know"), std::string::npos) << message;
  EXPECT_NE(message.find("expected version 1, found version 2"), std::string::npos) << message;
  file = sound_file();
  file[3] = std::byte{'x'};
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("is not an index file"), std::string::npos);
}

/// Values that break sums, products and comparisons.
std::vector<std::uint64_t> hostile_numbers(const Bytes& file) {
  std::vector<std::uint64_t> numbers = {0,  1,  7,    8,    31,   32,          33,
                                        43, 44, 4095, 4096, 8192, file.size(), file.size() + 1};
  for (const int power : {15, 16, 31, 32, 52, 59, 60, 61, 62, 63, 64}) {
    const std::uint64_t number = power == 64 ? 0 : std::uint64_t{1} << power;
    for (const int step : {-4096, -64, -1, 0, 1, 64})
      numbers.push_back(number + static_cast<std::uint64_t>(step));
  }
  return numbers;
}

TEST(IndexDamage, no_number_in_the_header_does_harm_even_with_a_right_checksum) {
  const Bytes& sound = sound_file();
  const std::size_t table_end = 256 + 32 * test::section_rows(sound).size();
  int refused = 0;
  for (std::size_t place = 16; place < table_end; place += 4) {
    for (const std::uint64_t number : hostile_numbers(sound)) {
      for (const bool wide : {false, true}) {
        Bytes file = sound;
        if (wide) {
          put(file, place, number);
        } else {
          put(file, place, static_cast<std::uint32_t>(number));
        }
        seal_header(file);
        refused += is_refused(file);
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(IndexDamage, counts_larger_than_the_file_are_errors_when_opened) {
  for (const std::size_t place : {40, 48}) {
    for (const std::uint64_t count : {std::uint64_t{100000}, std::uint64_t{0xfffffffe},
                                      std::uint64_t{1} << 58, std::numeric_limits<std::uint64_t>::max()}) {
      Bytes file = sound_file();
      put(file, place, count);
      seal_header(file);
      EXPECT_TRUE(is_refused_when_opened(file)) << place << " " << count;
    }
  }
}

TEST(IndexDamage, overlapping_sections_and_gaps_between_them_are_errors_when_opened) {
  const Bytes& sound = sound_file();
  const std::vector<SectionRow> rows = test::section_rows(sound);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    for (const std::uint64_t place : {rows[i - 1].place, rows[i].place - 4096, rows[i].place - 1,
                                      rows[i].place + 1, rows[i].place + 4096}) {
      Bytes file = sound;
      put(file, rows[i].row + 8, place);
      seal_header(file);
      EXPECT_TRUE(is_refused_when_opened(file)) << i << " " << place;
    }
    Bytes swapped = sound;
    put(swapped, rows[i].row, rows[i - 1].kind);
    put(swapped, rows[i - 1].row, rows[i].kind);
    seal_header(swapped);
    EXPECT_TRUE(is_refused_when_opened(swapped)) << i;
  }
}

TEST(IndexDamage, something_between_the_sections_is_found_by_verifying) {
  Bytes file = sound_file();
  const SectionRow row = section(file, IndexSection::coordinates);
  file[row.place - 1] = std::byte{1};
  EXPECT_NE(error_of([&] { test::index_in_memory(file).verify(); }).find("before section coordinates"),
            std::string::npos);
}

/// Byte of a node's field in the file.
std::size_t in_node(const Bytes& file, std::size_t node, std::size_t field) {
  return section(file, IndexSection::nodes).place + node * sizeof(Node) + field;
}
constexpr std::size_t k_kind = 48, k_first_child = 56, k_first_point = 60;

/// What octree() says of a file whose node was changed by `change` and whose checksums are right.
template <class Change>
std::string problem_after(const Change& change) {
  Bytes file = sound_file();
  change(file);
  seal(file);
  const IndexFile index = test::index_in_memory(file);
  return error_of([&] { index.octree(); });
}

TEST(IndexDamage, broken_links_are_errors_even_with_right_checksums) {
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find("section nodes is damaged"), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const std::uint64_t nodes = section(sound_file(), IndexSection::nodes).bytes / sizeof(Node);
  for (const std::uint32_t child : {0u, static_cast<std::uint32_t>(nodes), 0xffffffffu, 0xfffffff8u}) {
    expect(problem_after([&](Bytes& file) { put(file, in_node(file, 0, k_first_child), child); }),
           "its child should be a node behind it");
  }
  // Node 1 is a child of the root; the root's first child moved on takes a node away from somebody else.
  expect(problem_after([](Bytes& file) { put<std::uint32_t>(file, in_node(file, 0, k_first_child), 2); }),
         "node");
  expect(problem_after(
             [](Bytes& file) { put<std::uint32_t>(file, in_node(file, 0, k_first_point), 0xffffff00u); }),
         "its leaves should end at place");
  for (const int kind : {33, 36, 127}) {
    expect(problem_after([&](Bytes& file) {
             for (std::size_t slot = 0; slot < 8; ++slot)
               put(file, in_node(file, 0, k_kind + slot), std::uint8_t(kind));
           }),
           "a leaf has more than 32 points");
  }
  expect(problem_after([](Bytes& file) {
           for (std::size_t slot = 0; slot < 8; ++slot) {
             const std::size_t place = in_node(file, 0, k_kind + slot);
             if (get<std::uint8_t>(file, place) >= 128) put(file, place, std::uint8_t{128 + 8});
           }
         }),
         "levels below");
  expect(problem_after([](Bytes& file) {
           put<std::uint32_t>(file, 60, 1);  // level count
         }),
         "it should have no child on level 1");
}

TEST(IndexDamage, points_that_do_not_stand_one_after_another_are_an_error_even_with_right_checksums) {
  const std::uint64_t nodes = section(sound_file(), IndexSection::nodes).bytes / sizeof(Node);
  const std::string message = problem_after([&](Bytes& file) {
    const std::size_t place = in_node(file, nodes - 1, k_first_point);
    put(file, place, get<std::uint32_t>(file, place) - 1);
  });
  EXPECT_NE(message.find("its points should begin at place"), std::string::npos) << message;
}

TEST(IndexDamage, a_leaf_too_high_for_its_coordinates_needs_exact_positions_even_with_right_checksums) {
  const std::string message = problem_after([](Bytes& file) {
    for (std::size_t node = 0;; ++node) {
      const auto exact = get<std::uint32_t>(file, 132);
      if (get<std::uint32_t>(file, in_node(file, node, k_first_point)) < exact) continue;
      put<std::uint32_t>(file, in_node(file, node, k_first_point), 0);
      return;
    }
  });
  EXPECT_NE(message.find("too high to go without exact positions"), std::string::npos) << message;
}

TEST(IndexDamage, an_id_beyond_the_points_is_an_error_even_with_a_right_checksum) {
  const std::uint64_t points = get<std::uint64_t>(sound_file(), 40);
  for (const std::uint64_t place : {std::uint64_t{0}, points / 2, points - 1}) {
    const std::string message = problem_after([&](Bytes& file) {
      put(file, section(file, IndexSection::ids).place + 4 * place, static_cast<std::uint32_t>(points));
    });
    EXPECT_NE(message.find("section ids is damaged: the id should be below 1508 but is 1508"),
              std::string::npos)
        << message;
    EXPECT_NE(
        message.find("byte " + std::to_string(section(sound_file(), IndexSection::ids).place + 4 * place)),
        std::string::npos)
        << message;
  }
}

TEST(IndexDamage, no_nodes_do_harm_even_with_right_checksums) {
  test::Random random;
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes file = sound_file();
    const SectionRow row = section(file, IndexSection::nodes);
    for (std::uint64_t changes = 1 + random.below(4); changes > 0; --changes) {
      const std::uint64_t node = random.below(row.bytes / sizeof(Node));
      switch (random.below(4)) {
        case 0:
          put(file, in_node(file, node, k_kind + random.below(8)), static_cast<std::uint8_t>(random.bits()));
          break;
        case 1:
          put(file, in_node(file, node, k_first_child),
              static_cast<std::uint32_t>(random.below(row.bytes / 32)));
          break;
        case 2:
          put(file, in_node(file, node, k_first_point), static_cast<std::uint32_t>(random.below(2000)));
          break;
        default:
          put(file, in_node(file, node, random.below(48)), static_cast<std::uint8_t>(random.bits()));
      }
    }
    seal(file);
    refused += is_refused(file);
  }
  EXPECT_GT(refused, 1000);
}

TEST(IndexDamage, no_metadata_do_harm_even_with_right_checksums) {
  test::Random random;
  int refused = 0;
  const SectionRow row = section(sound_file(), IndexSection::metadata);
  for (std::uint64_t place = row.place; place < row.place + row.bytes; ++place) {
    for (const std::uint64_t number : {std::uint64_t{0}, std::uint64_t{1} << 20, std::uint64_t{1} << 62,
                                       std::numeric_limits<std::uint64_t>::max(), random.bits()}) {
      Bytes file = sound_file();
      if (place + 8 <= row.place + row.bytes) put(file, place, number);
      seal(file);
      refused += is_refused_when_opened(file);
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(IndexDamage, contents_that_contradict_each_other_are_found_by_verifying_even_with_right_checksums) {
  const auto expect = [](const std::string& part, const auto& change) {
    Bytes file = sound_file();
    change(file);
    seal(file);
    EXPECT_FALSE(is_refused(file)) << part;
    const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect("occurs twice", [](Bytes& file) {
    const std::uint64_t place = section(file, IndexSection::ids).place;
    put(file, place, get<std::uint32_t>(file, place + 4));
  });
  expect("outside the box", [](Bytes& file) {
    const std::uint64_t place = section(file, IndexSection::coordinates).place;
    put<std::uint16_t>(file, place, static_cast<std::uint16_t>(get<std::uint16_t>(file, place) + 30000));
  });
  expect("section positions is damaged", [](Bytes& file) {
    const std::uint64_t place = section(file, IndexSection::positions).place;
    put<std::int32_t>(file, place, get<std::int32_t>(file, place) ^ 0x40000000);
  });
  expect("bounds are not those of the points",
         [](Bytes& file) { put(file, 136, get<double>(file, 136) - 1.0); });
  expect("levels", [](Bytes& file) { put<std::uint32_t>(file, 60, get<std::uint32_t>(file, 60) + 1); });
}

TEST(IndexDamage, files_on_disk_are_named_with_the_damaged_byte) {
  const auto path = test::test_folder() / "site.alidade";
  Bytes file = sound_file();
  file[64] ^= std::byte{1};
  test::write_bytes(path, file);
  EXPECT_NE(error_of([&] { open_index(path); }).find(path.string() + ":byte 32: the header is damaged"),
            std::string::npos);
  test::write_bytes(path, {});
  EXPECT_NE(error_of([&] { open_index(path); }).find("is not an index file"), std::string::npos);
  EXPECT_NE(error_of([&] { open_index(path.parent_path()); }).find("a regular file"), std::string::npos);
  EXPECT_NE(error_of([&] { open_index(path.parent_path() / "absent"); }).find("cannot be opened"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade
