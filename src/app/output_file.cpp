#include "app/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Beside `path` and with its ending, which names the format; the process number keeps runs apart.
fs::path beside(const fs::path& path) {
  return folder_of(path) / fmt::format(".{}.{}{}", path.stem().string(), getpid(), path.extension().string());
}

}  // namespace

void check_can_write(const fs::path& path, const std::string& option) {
  std::error_code error;
  const fs::path folder = folder_of(path);
  if (!path.has_filename() || fs::is_directory(path, error))
    throw InputError(fmt::format("{} {} is a folder", option, path.string()), "name a file in it");
  if (!fs::is_directory(folder, error))
    throw InputError(fmt::format("{}: there is no folder {}", option, folder.string()),
                     fmt::format("make it first: mkdir -p {}", folder.string()));
  const fs::path probe = beside(path);
  const bool writable = [&] { return std::ofstream(probe).good(); }();
  const auto reason = std::error_code(errno, std::generic_category());
  fs::remove(probe, error);
  if (!writable)
    throw InputError(fmt::format("{} {} cannot be written: {}", option, path.string(), reason.message()),
                     "choose a folder that you may write to and that has room");
}

void write_beside(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  const fs::path temporary = beside(path);
  std::error_code error;
  try {
    write(temporary);
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
  fs::rename(temporary, path, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  throw RunError(fmt::format("{} cannot be written: {}", path.string(), error.message()));
}

void write_text(const fs::path& path, const std::string& text) {
  write_beside(path, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw RunError(fmt::format("{} cannot be written", path.string()), "is the disk full?");
  });
}

}  // namespace ringsplat::app
