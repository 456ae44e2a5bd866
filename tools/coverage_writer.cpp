// SPDX-License-Identifier: MIT
#include "tools/coverage_writer.h"

#include "tools/load_module.h"

namespace alidade {

CoverageWriter load_coverage_writer() {
  return load_module_function<CoverageWriter>("alidade_write_coverage_picture");
}

}  // namespace alidade
