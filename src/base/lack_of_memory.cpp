#include "base/lack_of_memory.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <new>
#include <system_error>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

std::string line_of(const std::string& rank) {
  return fmt::format("ringsplat{}: error: {}; hint: use more ranks on more machines, or a smaller --size\n",
                     rank, lack_of_memory);
}

/// Made beforehand, and never gone.
std::string& line = *new std::string(line_of(""));

[[noreturn]] void end_for_lack_of_memory() {
  say_lack_of_memory();
  _exit(int(ExitCode::run_failed));
}

std::terminate_handler end_otherwise = nullptr;

[[noreturn]] void end_by_exception() {
  try {
    if (std::current_exception()) throw;
    // What a library that could start only some of its threads makes of the others, which find no memory.
    if (!has_address_space(std::size_t{256} << 20)) end_for_lack_of_memory();
  } catch (const std::exception& error) {
    if (is_lack_of_memory(error)) end_for_lack_of_memory();
  } catch (...) {
  }
  end_otherwise();
  std::abort();
}

}  // namespace

bool is_lack_of_memory(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return true;
  const auto* system = dynamic_cast<const std::system_error*>(&error);
  return system != nullptr && system->code() == std::errc::resource_unavailable_try_again;
}

void say_lack_of_memory() noexcept { static_cast<void>(!write(STDERR_FILENO, line.data(), line.size())); }

void name_in_lack_of_memory(const std::string& rank) { line = line_of(rank); }

bool has_address_space(std::size_t bytes) {
  void* const space = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (space == MAP_FAILED) return false;
  munmap(space, bytes);
  return true;
}

void prepare_for_lack_of_memory() {
  if (end_otherwise == nullptr) end_otherwise = std::set_terminate(end_by_exception);
}

}  // namespace ringsplat
