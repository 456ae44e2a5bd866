// SPDX-License-Identifier: MIT
// Commands that make files of clouds. Each runs a job.
#include "jobs/clouds/catalog.h"
#include "jobs/clouds/convert.h"
#include "jobs/clouds/generate.h"
#include "jobs/clouds/index.h"
#include "tools/command.h"

namespace alidade::tools {

Command add_generate(const Options& program) {
  return job_command(program.command("generate", "Scan a simulated site into a LAS or LAZ file"),
                     jobs::add_generate_fields);
}

Command add_index(const Options& program) {
  return job_command(program.command("index", "Build an index file, which replaces cloud files"),
                     jobs::add_index_fields);
}

Command add_catalog(const Options& program) {
  return job_command(
      program.command("catalog", "List many clouds with their bounds, so that few need be opened"),
      jobs::add_catalog_fields);
}

Command add_convert(const Options& program) {
  return job_command(program.command("convert", "Convert, join, crop and thin clouds"),
                     jobs::add_convert_fields);
}

}  // namespace alidade::tools
