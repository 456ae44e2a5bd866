// SPDX-License-Identifier: MIT
#include <malloc.h>

#include <new>

#include "base/error.h"
#include "tools/command.h"
#include "tools/console.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  using namespace alidade::tools;
  // Batches of rays take the same megabytes again and again: without this, each would get its pages from the
  // system and clear them, a third of the time of some pictures.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 128 << 20);
  catch_interrupts();
  ExitCode code = ExitCode::failed;
  try {
    ProgramHooks extensions;
    add_extensions(extensions);
    code = run_program(CommandLine(arguments, arguments + argument_count), extensions);
  } catch (const Cancelled&) {
    say_error("interrupted");
    code = ExitCode::interrupted;
  } catch (const ReaderGone&) {
    end_by_broken_pipe();
  } catch (const std::bad_alloc&) {
    say_error("not enough memory");
  } catch (const std::exception& error) {
    say_error(error.what());
  }
  return static_cast<int>(code);
}
