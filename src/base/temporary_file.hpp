#pragma once
#include <filesystem>
#include <system_error>

namespace ringsplat::detail {

std::filesystem::path folder_of(const std::filesystem::path& path);

/// A hidden file beside `path`, `.ringsplat_HOST_PID-N_NAME`: HOST with every byte but letters, digits, dots
/// and dashes as %XX, N counted by the process, NAME that of `path`, cut from the front when it is too long.
/// Locked while it is open. remove_unfinished_files() removes it while this object lives; there are places
/// for 64 at a time, and further ones are not registered.
class TemporaryFile {
 public:
  /// Says in `error` why it could not be made; nothing else may be called then. The first one in a folder
  /// removes what dead processes left there. No signal arrives between making the file and registering it.
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
  void make();
  void forget();

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool unfinished_ = false;
  int place_ = -1;  ///< below 0: not registered
};

/// Removes from a folder the unfinished files of dead processes of this user and host. In doubt a file stays.
void remove_stale_files(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
