#include "serve/opened_page.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "base/child_program.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {
namespace {

/// The user's own folder of what lasts no longer than a login, in memory; empty when there is none.
std::filesystem::path fleeting_folder() {
  const char* const own = std::getenv("XDG_RUNTIME_DIR");
  return own != nullptr && access(own, W_OK | X_OK) == 0 ? own : "";
}

void write_redirect(const std::filesystem::path& file, const std::string& url) {
  const std::string text = fmt::format(
      "<!doctype html><meta charset=\"utf-8\"><title>Ringsplat</title>"
      "<meta http-equiv=\"refresh\" content=\"0; url={0}\"><a href=\"{0}\">Ringsplat</a>\n",
      url);
  const int to = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool written = to >= 0 && write(to, text.data(), text.size()) == ssize_t(text.size());
  if (to >= 0) close(to);
  if (!written) throw RunError(fmt::format("{} cannot be written", file.string()));
}

}  // namespace

OpenedPage::OpenedPage(const std::string& url) : folder_("page", fleeting_folder()) {
  const std::filesystem::path file = folder_.path() / "page.html";
  write_redirect(file, url);
  const auto program = find_program("xdg-open");
  if (!program) throw RunError("there is no xdg-open");
  start_program(*program, {file.string()}, "/");
}

}  // namespace ringsplat::serve
