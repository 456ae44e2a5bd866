// SPDX-License-Identifier: MIT
// Index files that were tampered with and given right checksums: the checks other than checksums must
// suffice.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "octree/index_file/save_index.h"
#include "octree/octree.h"
#include "tests/octree/index_file/damaged_index.h"

namespace alidade {
namespace {

using test::Bytes;
using test::error_of;
using test::get;
using test::in_node;
using test::is_rejected;
using test::is_rejected_when_opened;
using test::k_first_child;
using test::k_first_point;
using test::k_kind;
using test::put;
using test::seal;
using test::seal_header;
using test::section;
using test::SectionRow;
using test::sound_file;

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

TEST(IndexForgery, no_number_in_the_header_does_harm) {
  const Bytes& sound = sound_file();
  const std::size_t table_end = 256 + 32 * test::section_rows(sound).size();
  int rejected = 0;
  for (std::size_t offset = 16; offset < table_end; offset += 4) {
    for (const std::uint64_t number : hostile_numbers(sound)) {
      for (const bool wide : {false, true}) {
        if (wide ? offset % 8 != 0 : number > 0xffffffffu) continue;
        Bytes file = sound;
        if (wide) {
          put(file, offset, number);
        } else {
          put(file, offset, static_cast<std::uint32_t>(number));
        }
        seal_header(file);
        rejected += is_rejected(file);
      }
    }
  }
  EXPECT_GT(rejected, 1000);
}

/// What octree() says of a file whose node was changed by `change` and whose checksums are right.
template <class Change>
std::string problem_after(const Change& change) {
  Bytes file = sound_file();
  change(file);
  seal(file);
  const IndexFile index = test::index_in_memory(file);
  return error_of([&] { index.octree(); });
}

TEST(IndexForgery, broken_links_are_errors) {
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find("corrupt section nodes"), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const std::uint64_t nodes = section(sound_file(), IndexSection::nodes).bytes / sizeof(Node);
  for (const std::uint32_t child : {0u, static_cast<std::uint32_t>(nodes), 0xffffffffu, 0xfffffff8u}) {
    expect(problem_after([&](Bytes& file) { put(file, in_node(file, 0, k_first_child), child); }),
           "invalid child; expected a later node below");
  }
  // Node 1 is a child of the root; the root's first child moved on takes a node away from somebody else.
  expect(problem_after([](Bytes& file) { put<std::uint32_t>(file, in_node(file, 0, k_first_child), 2); }),
         "node");
  expect(problem_after(
             [](Bytes& file) { put<std::uint32_t>(file, in_node(file, 0, k_first_point), 0xffffff00u); }),
         "its leaves end at a wrong storage index; expected");
  for (const int kind : {33, 36, 127}) {
    expect(problem_after([&](Bytes& file) {
             for (std::size_t slot = 0; slot < k_node_width; ++slot)
               put(file, in_node(file, 0, k_kind + slot), std::uint8_t(kind));
           }),
           "a leaf has more than 32 points");
  }
  const auto lower_inner_by = [](Bytes& file, int drop) {
    for (std::size_t slot = 0; slot < k_node_width; ++slot) {
      const std::size_t offset = in_node(file, 0, k_kind + slot);
      if (get<std::uint8_t>(file, offset) >= k_inner_kind)
        put(file, offset, static_cast<std::uint8_t>(k_inner_kind + drop));
    }
  };
  expect(problem_after([&](Bytes& file) {
           lower_inner_by(file, 1);
           put<std::uint32_t>(file, 56, k_min_frame_level);
         }),
         "child 1 is 1 levels below level 8");
  expect(problem_after([&](Bytes& file) { lower_inner_by(file, k_max_level_drop + 1); }),
         "levels below level");
  expect(problem_after([&](Bytes& file) {
           // The first node whose children come after another node's last child gets that child, too.
           const auto last_child = [&](std::uint32_t node) {
             const Node parent = get<Node>(file, in_node(file, node, 0));
             return parent.first_child + static_cast<std::uint32_t>(std::popcount(inner_slots(parent))) - 1;
           };
           const auto is_parent = [&](std::uint32_t node) {
             return inner_slots(get<Node>(file, in_node(file, node, 0))) != 0;
           };
           for (std::uint32_t node = 1; node < nodes; ++node) {
             for (std::uint32_t before = 0; before < node; ++before) {
               if (!is_parent(before) || !is_parent(node) || last_child(before) <= node) continue;
               put(file, in_node(file, node, k_first_child), last_child(before));
               return;
             }
           }
         }),
         "also belongs to another node");
  expect(problem_after([](Bytes& file) {
           put<std::uint32_t>(file, 60, 1);  // level count
         }),
         "unexpected child on level 1");
}

/// What is said of a file with one value of its header changed and a right checksum.
template <class T>
std::string problem_of_header(std::size_t offset, T value) {
  Bytes file = sound_file();
  put(file, offset, value);
  seal_header(file);
  return error_of([&] { test::index_in_memory(file); });
}

TEST(IndexForgery, a_number_just_outside_its_range_has_an_error_of_its_own) {
  const auto expect = [](std::size_t offset, auto value, const std::string& part) {
    const std::string message = problem_of_header(offset, value);
    EXPECT_NE(message.find(part), std::string::npos) << offset << " " << value << ": " << message;
  };
  const auto points = static_cast<std::uint32_t>(get<std::uint64_t>(sound_file(), 40));
  const double infinity = std::numeric_limits<double>::infinity();
  expect(16, 4097u, "wrong header size");
  expect(56, 7u, "invalid root level");
  expect(56, 33u, "invalid root level");
  expect(60, 0u, "invalid number of levels");
  expect(60, static_cast<std::uint32_t>(k_max_tree_depth + 1), "invalid number of levels");
  expect(64, 3u, "unknown organisation");
  expect(68, 2u, "unknown flags");
  expect(132, points + 1, "invalid storage index of the first exact position");
  expect(216, std::uint16_t{255}, "invalid factor of colours");
  expect(204, 65u, "invalid number of neighbours");
  expect(204, 0u, "invalid length unit of surfaces");
  for (const std::size_t axis : {0, 1, 2}) {
    for (const double scale : {0.0, -1.0, std::nan(""), infinity})
      expect(72 + 8 * axis, scale, "invalid lattice scale");
    for (const double offset : {std::nan(""), infinity})
      expect(96 + 8 * axis, offset, "invalid lattice offset");
    for (const double bound : {std::nan(""), -infinity, 1e300})
      expect(136 + 8 * axis, bound, "invalid bounds");
  }
}

TEST(IndexForgery, a_section_that_is_not_as_its_kind_has_an_error_of_its_own) {
  const std::vector<SectionRow> rows = test::section_rows(sound_file());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::uint32_t element = get<std::uint32_t>(sound_file(), rows[i].row + 4);
    EXPECT_NE(problem_of_header(rows[i].row + 4, element + 1).find("wrong element size"), std::string::npos);
    if (i == 0) continue;
    EXPECT_NE(problem_of_header(rows[i].row, rows[i - 1].kind).find("sections out of order"),
              std::string::npos);
  }
}

TEST(IndexForgery, bytes_after_the_last_section_are_an_error) {
  Bytes file = sound_file();
  file.resize(file.size() + 1);
  put<std::uint64_t>(file, 24, file.size());
  seal_header(file);
  const std::string message = error_of([&] { test::index_in_memory(file); });
  EXPECT_NE(message.find("extra bytes after the last section"), std::string::npos) << message;
}

TEST(IndexForgery, leaves_that_end_one_point_too_late_are_an_error) {
  const std::string message = problem_after([](Bytes& file) {
    auto first = static_cast<std::uint32_t>(get<std::uint64_t>(file, 40) + 1);
    for (std::size_t slot = 0; slot < k_node_width; ++slot) {
      const auto kind = get<std::uint8_t>(file, in_node(file, 0, k_kind + slot));
      if (kind <= k_max_leaf_size) first -= kind;
    }
    put(file, in_node(file, 0, k_first_point), first);
  });
  EXPECT_NE(message.find("its leaves end at a wrong storage index; expected 1508, found 1509"),
            std::string::npos)
      << message;
}

TEST(IndexForgery, points_that_do_not_stand_one_after_another_are_an_error) {
  const std::uint64_t nodes = section(sound_file(), IndexSection::nodes).bytes / sizeof(Node);
  const std::string message = problem_after([&](Bytes& file) {
    const std::size_t offset = in_node(file, nodes - 1, k_first_point);
    put(file, offset, get<std::uint32_t>(file, offset) - 1);
  });
  EXPECT_NE(message.find("its points begin at a wrong storage index; expected"), std::string::npos)
      << message;
}

TEST(IndexForgery, a_leaf_too_high_for_its_coordinates_needs_exact_positions) {
  const std::string message = problem_after([](Bytes& file) {
    for (std::size_t node = 0;; ++node) {
      const auto exact = get<std::uint32_t>(file, 132);
      if (get<std::uint32_t>(file, in_node(file, node, k_first_point)) < exact) continue;
      put<std::uint32_t>(file, in_node(file, node, k_first_point), 0);
      return;
    }
  });
  EXPECT_NE(message.find("its leaves require exact positions"), std::string::npos) << message;
}

TEST(IndexForgery, an_id_beyond_the_points_is_an_error) {
  const std::uint64_t points = get<std::uint64_t>(sound_file(), 40);
  for (const std::uint64_t offset : {std::uint64_t{0}, points / 2, points - 1}) {
    const std::string message = problem_after([&](Bytes& file) {
      put(file, section(file, IndexSection::ids).offset + 4 * offset, static_cast<std::uint32_t>(points));
    });
    EXPECT_NE(message.find("corrupt section ids: id out of range; expected less than 1508, found 1508"),
              std::string::npos)
        << message;
    EXPECT_NE(
        message.find("byte " + std::to_string(section(sound_file(), IndexSection::ids).offset + 4 * offset)),
        std::string::npos)
        << message;
  }
}

TEST(IndexForgery, no_nodes_do_harm) {
  test::Random random;
  int rejected = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes file = sound_file();
    const SectionRow row = section(file, IndexSection::nodes);
    for (std::uint64_t changes = 1 + random.below(4); changes > 0; --changes) {
      const std::uint64_t node = random.below(row.bytes / sizeof(Node));
      switch (random.below(4)) {
        case 0:
          put(file, in_node(file, node, k_kind + random.below(k_node_width)),
              static_cast<std::uint8_t>(random.bits()));
          break;
        case 1:
          put(file, in_node(file, node, k_first_child),
              static_cast<std::uint32_t>(random.below(row.bytes / 32)));
          break;
        case 2:
          put(file, in_node(file, node, k_first_point), static_cast<std::uint32_t>(random.below(2000)));
          break;
        default:
          put(file, in_node(file, node, random.below(k_kind)), static_cast<std::uint8_t>(random.bits()));
      }
    }
    seal(file);
    rejected += is_rejected(file);
  }
  EXPECT_GT(rejected, 1000);
}

TEST(IndexForgery, metadata_that_disagree_with_sections_are_an_error) {
  const auto expect = [](const std::string& part, const auto& change) {
    Bytes file = sound_file();
    change(file);
    seal(file);
    const std::string message = error_of([&] { (void)test::index_in_memory(file).columns(); });
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  // The longest of the records (fill_everything).
  constexpr std::uint64_t k_record_bytes = 70000;
  const auto put_record_bytes = [](Bytes& file, std::uint64_t bytes) {
    std::size_t offset = section(file, IndexSection::metadata).offset;
    while (get<std::uint64_t>(file, offset) != k_record_bytes) ASSERT_LT(++offset + 8, file.size());
    put(file, offset, bytes);
  };
  expect("the data of the records exceeds its section",
         [&](Bytes& file) { put_record_bytes(file, k_record_bytes + 1); });
  expect("the section of record data is too long",
         [&](Bytes& file) { put_record_bytes(file, k_record_bytes - 1); });
  expect("wrong size of", [](Bytes& file) {
    const SectionRow row = section(file, IndexSection::extra_dimensions);
    put(file, row.row + 16, row.bytes - 1);
  });
}

TEST(IndexForgery, no_metadata_do_harm) {
  test::Random random;
  int rejected = 0;
  const SectionRow row = section(sound_file(), IndexSection::metadata);
  for (std::uint64_t offset = row.offset; offset < row.offset + row.bytes; ++offset) {
    for (const std::uint64_t number : {std::uint64_t{0}, std::uint64_t{1} << 20, std::uint64_t{1} << 62,
                                       std::numeric_limits<std::uint64_t>::max(), random.bits()}) {
      Bytes file = sound_file();
      if (offset + 8 <= row.offset + row.bytes) put(file, offset, number);
      seal(file);
      rejected += is_rejected_when_opened(file);
    }
  }
  EXPECT_GT(rejected, 1000);
}

TEST(IndexForgery, no_coordinates_do_harm) {
  test::Random random;
  for (int i = 0; i < 200; ++i) {
    Bytes file = sound_file();
    const SectionRow row = section(file, IndexSection::coordinates);
    for (std::uint64_t offset = row.offset; offset + 8 <= row.offset + row.bytes; offset += 8)
      if (random.below(4) < 1 + static_cast<std::uint64_t>(i % 3)) put(file, offset, random.bits());
    seal(file);
    EXPECT_FALSE(is_rejected(file));
  }
}

TEST(IndexForgery, no_spacings_do_harm) {
  test::Random random;
  for (int i = 0; i < 200; ++i) {
    Bytes file = sound_file();
    for (const IndexSection kind : {IndexSection::spacings, IndexSection::slot_spacings}) {
      const SectionRow row = section(file, kind);
      for (std::uint64_t offset = row.offset; offset + 8 <= row.offset + row.bytes; offset += 8)
        if (random.below(4) < 1 + static_cast<std::uint64_t>(i % 3)) put(file, offset, random.bits());
    }
    seal(file);
    EXPECT_FALSE(is_rejected(file));
  }
}

TEST(IndexForgery, spacings_whose_header_and_sections_disagree_are_errors) {
  Bytes file = sound_file();
  put<std::uint32_t>(file, 204, 0);
  seal(file);
  EXPECT_TRUE(test::is_rejected_when_opened(file));
  put<std::uint32_t>(file, 204, 65);
  seal(file);
  EXPECT_TRUE(test::is_rejected_when_opened(file));
}

TEST(IndexForgery, colors_whose_header_and_section_disagree_are_errors) {
  EXPECT_NE(problem_of_header(216, std::uint16_t{257}).find("wrong element size of column color"),
            std::string::npos);
  const auto path = test::test_folder() / "plain.alidade";
  const PointCloud plain = test::make_cloud({{1, 2, 3}, {2, 3, 4}}, {glm::dvec3(1), glm::dvec3(0)});
  save_index(path, build(plain), plain, {.overwrite = true});
  Bytes file = test::read_bytes(path);
  EXPECT_FALSE(test::is_rejected_when_opened(file));
  put(file, 216, std::uint16_t{257});
  seal_header(file);
  EXPECT_TRUE(test::is_rejected_when_opened(file));
}

TEST(IndexForgery, no_surfaces_do_harm) {
  test::Random random;
  for (int i = 0; i < 50; ++i) {
    Bytes file = sound_file();
    const SectionRow row = section(file, IndexSection::surfaces);
    for (std::uint64_t offset = row.offset; offset + 8 <= row.offset + row.bytes; offset += 8)
      put(file, offset, random.bits());
    const SectionRow edges = section(file, IndexSection::sheet_edges);
    for (std::uint64_t offset = edges.offset; offset < edges.offset + edges.bytes; ++offset)
      put(file, offset, static_cast<std::uint8_t>(random.bits()));
    seal(file);
    EXPECT_FALSE(is_rejected(file));
  }
}

TEST(IndexForgery, surfaces_whose_header_and_sections_disagree_are_errors) {
  for (const double unit : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    Bytes file = sound_file();
    put(file, 208, unit);
    seal(file);
    EXPECT_TRUE(test::is_rejected_when_opened(file)) << unit;
  }
}

}  // namespace
}  // namespace alidade
