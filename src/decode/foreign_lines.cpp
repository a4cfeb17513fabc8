#include "decode/foreign_lines.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace ringsplat::decode {

ForeignLines::ForeignLines() : caught_(::memfd_create("stderr", MFD_CLOEXEC)) {
  if (caught_ >= 0) ::dup2(caught_, STDERR_FILENO);
}

std::string ForeignLines::first_line() {
  constexpr off_t most = 1000;
  std::fflush(stderr);
  std::string text(std::size_t(std::clamp<off_t>(::lseek(caught_, 0, SEEK_END), 0, most)), '\0');
  text.resize(std::size_t(std::max<ssize_t>(0, ::pread(caught_, text.data(), text.size(), 0))));
  if (!text.empty() && ::ftruncate(caught_, 0) == 0) ::lseek(caught_, 0, SEEK_SET);
  return text.substr(0, text.find('\n'));
}

}  // namespace ringsplat::decode
