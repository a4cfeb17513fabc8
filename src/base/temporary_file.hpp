#pragma once
#include <filesystem>
#include <memory>
#include <system_error>

#include "base/unfinished_files.hpp"

namespace ringsplat::detail {

std::filesystem::path folder_of(const std::filesystem::path& path);

/// A hidden file beside `path`, `.ringsplat_HOST_PID-N_NAME`: HOST with every byte but letters, digits, dots
/// and dashes as %XX, N counted by the process, NAME that of `path`, cut from the front when it is too long.
/// Locked while it is open.
class TemporaryFile {
 public:
  /// Says in `error` why it could not be made; nothing else may be called then. The first one in a folder
  /// removes what dead processes left there.
  TemporaryFile(const std::filesystem::path& path, std::error_code& error);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return descriptor_; }  ///< below 0: closed
  /// errno says why not; it is closed in any case.
  bool close();
  /// Keeps the file, under that name. errno says why not.
  bool rename_to(const std::filesystem::path& path);

 private:
  std::filesystem::path path_;
  std::unique_ptr<UnfinishedFile> unfinished_;
  int descriptor_ = -1;
};

/// Removes from a folder the unfinished files of dead processes of this user and host. In doubt a file stays.
void remove_stale_files(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
