#pragma once
#include <filesystem>
#include <string>

namespace ringsplat::serve {

/// A folder that nobody else may look into (mode 0700) and that is gone, with all in it, with this object.
class PrivateFolder {
 public:
  /// Makes it in `parent`. Throws RunError when it cannot; `purpose` says what it is for.
  PrivateFolder(const std::filesystem::path& parent, const std::string& purpose);
  /// Below TMPDIR.
  explicit PrivateFolder(const std::string& purpose);
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ringsplat::serve
