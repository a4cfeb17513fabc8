#include "program/text_output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/output_file.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

bool is_stdout(const std::string& file) { return file == "-"; }

void check_can_write_text(const std::string& file, const std::string& option) {
  if (!is_stdout(file)) check_can_write(file, option);
}

void write_text_output(const std::string& file, const std::string& text) {
  if (!is_stdout(file)) {
    write_text(file, text);
    return;
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  flush_stdout();
}

void flush_stdout() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw RunError(fmt::format("standard output cannot be written{}{}", errno == 0 ? "" : ": ",
                             errno == 0 ? "" : std::strerror(errno)),
                 "is the disk full?");
}

}  // namespace ringsplat::app
