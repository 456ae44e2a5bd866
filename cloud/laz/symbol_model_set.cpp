// SPDX-License-Identifier: MIT
#include "cloud/laz/symbol_model_set.h"

namespace alidade {

void SymbolModelSet::prepare(Place& place) {
  if (place.model == nullptr) {
    place.model = std::make_unique<SymbolModel>(symbols_);
  } else {
    place.model->reset();
  }
  place.generation = generation_;
}

}  // namespace alidade
