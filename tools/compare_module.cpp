// SPDX-License-Identifier: MIT
#include "tools/compare_module.h"

#include "tools/load_module.h"

namespace alidade {

FileComparer load_file_comparer() {
  return load_module_function<FileComparer>("alidade_compare_files");
}

PairComparer load_pair_comparer() {
  return load_module_function<PairComparer>("alidade_compare_pairs");
}

ReportMaker load_report_maker() {
  return load_module_function<ReportMaker>("alidade_report_page");
}

DifferenceWriter load_difference_writer() {
  return load_module_function<DifferenceWriter>("alidade_write_difference");
}

}  // namespace alidade
