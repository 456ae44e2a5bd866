// SPDX-License-Identifier: MIT
#include "tools/map_reference.h"

#include "tools/load_module.h"

namespace alidade {

LonLatTransformer load_lon_lat() {
  return load_module_function<LonLatTransformer>("alidade_lon_lat");
}

UnitMeasure load_metres_per_unit() {
  return load_module_function<UnitMeasure>("alidade_metres_per_unit");
}

}  // namespace alidade
