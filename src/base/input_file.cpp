#include "base/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

FileStamp stamp_of(const struct stat& status) {
  return {static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

void require_same_stamp(const std::filesystem::path& file, const FileStamp& before, const FileStamp& now) {
  if (now == before) return;
  const std::string how = now.bytes == before.bytes
                              ? "other bytes"
                              : fmt::format("{} bytes instead of {}", now.bytes, before.bytes);
  throw InputError(fmt::format("{} has changed since it was opened: {}", file.string(), how),
                   "start again when nobody writes to it any more");
}

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  // Without O_NONBLOCK, opening a named pipe would wait for a writer for ever.
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0)
    throw InputError(fmt::format("cannot open {}: {}", path_.string(), std::strerror(errno)),
                     "check the path and the permissions");
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw InputError(fmt::format("{} is not a regular file", path_.string()), "give a volume file");
  }
  stamp_ = stamp_of(status);
}

InputFile::~InputFile() { ::close(descriptor_); }

std::shared_ptr<const char> InputFile::mapped() const {
  const auto bytes = std::max<std::size_t>(1, size());  // there is no mapping of none
  void* const at = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, descriptor_, 0);
  if (at == MAP_FAILED)
    throw InputError(fmt::format("cannot read {}: {}", path_.string(), std::strerror(errno)),
                     "check the disk");
  const auto unmap = [bytes](const char* begin) { ::munmap(const_cast<char*>(begin), bytes); };
  return {static_cast<const char*>(at), unmap};
}

std::size_t InputFile::read_some(std::uint64_t offset, std::span<std::byte> out) const {
  // One call reads 2 GiB at most.
  constexpr std::size_t most = std::size_t{1} << 30;
  std::size_t done = 0;
  while (done < out.size()) {
    const auto got = ::pread(descriptor_, out.data() + done, std::min(most, out.size() - done),
                             static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw InputError(
          fmt::format("cannot read {} at byte {}: {}", path_.string(), offset + done, std::strerror(errno)),
          "check the disk");
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

void InputFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  const auto got = read_some(offset, out);
  if (got == out.size()) return;
  require_unchanged();
  throw InputError(
      fmt::format("{} ends at byte {}, {} are needed", path_.string(), offset + got, offset + out.size()),
      "the file was cut short: copy it again");
}

void InputFile::require_unchanged() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0)
    throw InputError(fmt::format("cannot ask for the size of {}: {}", path_.string(), std::strerror(errno)),
                     "check the disk");
  require_same_stamp(path_, stamp_, stamp_of(status));
}

}  // namespace ringsplat::detail
