#include "program/process_end.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>

#include "base/lack_of_memory.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// Whether a library's thread might find no memory.
bool lacks_address_space() { return !has_address_space(std::size_t{256} << 20); }

[[noreturn]] void end_for_lack_of_memory() {
  say_lack_of_memory();
  _exit(int(ExitCode::run_failed));
}

std::terminate_handler end_otherwise = nullptr;

[[noreturn]] void end_by_exception() {
  try {
    if (std::current_exception()) throw;
    // What a library that could start only some of its threads makes of the others.
    if (lacks_address_space()) end_for_lack_of_memory();
  } catch (const std::exception& error) {
    if (is_lack_of_memory(error)) end_for_lack_of_memory();
  } catch (...) {
  }
  end_otherwise();
  std::abort();
}

}  // namespace

void prepare_for_lack_of_memory() { end_otherwise = std::set_terminate(end_by_exception); }

void ignore_file_size_signal() { signal(SIGXFSZ, SIG_IGN); }

}  // namespace ringsplat::app
