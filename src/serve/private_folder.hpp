#pragma once
#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {

/// A folder that nobody else may look into (mode 0700) and that is gone, with all in it, with this object.
class PrivateFolder {
 public:
  /// Makes it in `parent`; empty: below TMPDIR. Throws RunError when it cannot; `purpose` says what it is
  /// for.
  explicit PrivateFolder(const std::string& purpose, std::filesystem::path parent = {}) {
    std::error_code error;
    if (parent.empty()) parent = std::filesystem::temp_directory_path(error);
    std::string name = (parent / ("ringsplat-" + purpose + "-XXXXXX")).string();
    if (error || mkdtemp(name.data()) == nullptr)
      throw RunError(fmt::format("there is no temporary folder for a {}: {}", purpose,
                                 std::generic_category().message(error ? ENOENT : errno)),
                     "set TMPDIR to a folder on rank 0's machine");
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ringsplat::serve
