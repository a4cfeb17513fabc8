#include "volume/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path_, ignored))
    throw InputError(fmt::format("cannot write {}: it is a folder", path_.string()), "give a file name");
  beside_ = path_;
  beside_ += fmt::format(".part-{}", ::getpid());
  file_ = std::fopen(beside_.c_str(), "wbe");
  if (file_ == nullptr)
    throw InputError(fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)),
                     "check that the folder exists and may be written");
}

OutputFile::~OutputFile() {
  if (file_ == nullptr && gzip_ == nullptr) return;
  close();
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
}

void OutputFile::begin_gzip() {
  if (std::fflush(file_) != 0) fail(std::strerror(errno));
  // zlib writes on from where the header ended, through a descriptor of its own.
  const int descriptor = ::dup(::fileno(file_));
  gzip_ = descriptor < 0 ? nullptr : gzdopen(descriptor, "wb");
  if (gzip_ == nullptr) fail("cannot begin to compress");
}

void OutputFile::write(std::span<const std::byte> bytes) {
  constexpr std::size_t most = std::size_t{1} << 30;  // gzwrite counts in int
  while (!bytes.empty()) {
    const auto part = std::min(bytes.size(), most);
    const bool written = gzip_ != nullptr
                             ? gzwrite(gzip_, bytes.data(), static_cast<unsigned>(part)) == int(part)
                             : std::fwrite(bytes.data(), 1, part, file_) == part;
    if (!written) fail(std::strerror(errno));
    bytes = bytes.subspan(part);
  }
}

void OutputFile::commit() {
  const bool compressed = gzip_ == nullptr || gzclose(std::exchange(gzip_, nullptr)) == Z_OK;
  const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
  std::error_code failed;
  if (compressed && closed) std::filesystem::rename(beside_, path_, failed);
  if (compressed && closed && !failed) return;
  const std::string reason = failed ? failed.message() : std::strerror(errno);
  std::error_code ignored;
  std::filesystem::remove(beside_, ignored);
  fail(reason.c_str());
}

void OutputFile::fail(const char* what) {
  throw RunError(fmt::format("writing {} failed: {}", path_.string(), what),
                 "check the free space of the disk");
}

void OutputFile::close() {
  if (gzip_ != nullptr) gzclose(std::exchange(gzip_, nullptr));
  if (file_ != nullptr) std::fclose(std::exchange(file_, nullptr));
}

}  // namespace ringsplat::detail
