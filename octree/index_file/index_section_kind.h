// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "cloud/attributes.h"

// What stands in the sections of an index file (docs/index_file.md).

namespace alidade {

/// What a section holds. Attribute columns have the number k_first_column plus the attribute's bit number.
enum class IndexSection : std::uint32_t {
  nodes = 1,
  coordinates = 2,
  ids = 3,
  positions = 4,
  spacings = 5,
  slot_spacings = 6,
  surfaces = 7,
  sheet_edges = 8,
  first_column = 16,
  extra_dimensions = 27,
  metadata = 32,
  record_data = 33,
  checksums = 34,
};

/// The section with the column of an attribute.
IndexSection column_section(Attribute attribute);

/// "nodes", "column gps_time": what messages call a section.
std::string name(IndexSection section);

/// Bytes of one element of a section; 1 where elements have no fixed size.
std::uint32_t element_bytes(IndexSection kind);

}  // namespace alidade
