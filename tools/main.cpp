// SPDX-License-Identifier: MIT
#include <new>

#include "base/error.h"
#include "base/huge_memory.h"
#include "tools/command.h"
#include "tools/console.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  using namespace alidade::tools;
  keep_freed_memory();
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
