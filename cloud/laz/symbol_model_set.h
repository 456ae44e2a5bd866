// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "cloud/laz/symbol_model.h"

namespace alidade {

/// One SymbolModel per context, of which files use few: each is made when it is first asked for, and kept.
class SymbolModelSet {
 public:
  /// Requires what SymbolModel requires of `symbols`.
  SymbolModelSet(std::size_t contexts, int symbols) : symbols_(symbols), places_(contexts) {}

  /// The model of a context, which must be one.
  SymbolModel& operator[](std::size_t context) {
    Place& place = places_[context];
    if (place.generation != generation_) [[unlikely]]
      prepare(place);
    return *place.model;
  }

  /// All models are fresh again.
  void reset() { ++generation_; }

 private:
  struct Place {
    std::unique_ptr<SymbolModel> model;
    std::uint64_t generation = 0;  // in which the model was last made fresh
  };

  void prepare(Place& place);

  int symbols_;
  std::uint64_t generation_ = 1;
  std::vector<Place> places_;
};

}  // namespace alidade
