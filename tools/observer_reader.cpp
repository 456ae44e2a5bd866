// SPDX-License-Identifier: MIT
#include "tools/observer_reader.h"

#include "tools/load_module.h"

namespace alidade {

ObserverReader load_observer_reader() {
  return load_module_function<ObserverReader>("alidade_read_observers");
}

ObserverTransformer load_observer_transformer() {
  return load_module_function<ObserverTransformer>("alidade_transform_observers");
}

}  // namespace alidade
