#include "base/memory_file.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {
[[noreturn]] void fail(const char* what) {
  throw RunError(fmt::format("cannot {} a file in memory: {}", what, std::strerror(errno)),
                 "free memory or raise its limits");
}
}  // namespace

MemoryFile::MemoryFile() : descriptor_(::memfd_create("ringsplat", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail("make");
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

std::filesystem::path MemoryFile::path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

void MemoryFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) fail("write");
    bytes = bytes.subspan(std::size_t(done));
  }
}

}  // namespace ringsplat::detail
