// SPDX-License-Identifier: MIT
#include "octree/index_file/index_section_kind.h"

#include <array>
#include <bit>

#include "cloud/point_cloud.h"
#include "octree/node.h"

namespace alidade {

IndexSection column_section(Attribute attribute) {
  return static_cast<IndexSection>(static_cast<std::uint32_t>(IndexSection::first_column) +
                                   std::countr_zero(static_cast<std::uint32_t>(attribute)));
}

std::uint32_t element_bytes(IndexSection kind) {
  constexpr std::array<std::uint32_t, 12> k_columns = {6, 2, 2, 1, 2, 1, 4, 1, 2, 8, 12, 1};
  switch (kind) {
    case IndexSection::nodes:
      return sizeof(Node);
    case IndexSection::coordinates:
    case IndexSection::spacings:
    case IndexSection::slot_spacings:
      return sizeof(std::uint16_t);
    case IndexSection::ids:
    case IndexSection::surfaces:
      return sizeof(std::uint32_t);
    case IndexSection::positions:
      return sizeof(LatticePosition);
    case IndexSection::sheet_edges:
    case IndexSection::metadata:
    case IndexSection::record_data:
      return 1;
    case IndexSection::checksums:
      return sizeof(std::uint64_t);
    default: {
      const std::uint32_t column =
          static_cast<std::uint32_t>(kind) - static_cast<std::uint32_t>(IndexSection::first_column);
      return column < k_columns.size() ? k_columns[column] : 0;
    }
  }
}

std::string name(IndexSection section) {
  switch (section) {
    case IndexSection::nodes:
      return "nodes";
    case IndexSection::coordinates:
      return "coordinates";
    case IndexSection::ids:
      return "ids";
    case IndexSection::positions:
      return "positions";
    case IndexSection::spacings:
      return "spacings";
    case IndexSection::slot_spacings:
      return "slot spacings";
    case IndexSection::surfaces:
      return "surfaces";
    case IndexSection::sheet_edges:
      return "sheet edges";
    case IndexSection::metadata:
      return "metadata";
    case IndexSection::record_data:
      return "record data";
    case IndexSection::checksums:
      return "checksums";
    default: {
      AttributeSet attribute;
      attribute.bits = 1u << (static_cast<std::uint32_t>(section) -
                              static_cast<std::uint32_t>(IndexSection::first_column));
      return "column " + attribute_names(attribute).front();
    }
  }
}

}  // namespace alidade
