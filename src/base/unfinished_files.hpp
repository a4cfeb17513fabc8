#pragma once
#include <filesystem>

namespace ringsplat::detail {

/// A file that remove_unfinished_files() removes while this object lives. There are places for 64 at a time;
/// further ones are not registered.
class UnfinishedFile {
 public:
  /// Creates the file, which must not exist yet, for reading and writing. No signal arrives between creating
  /// and registering it. Leaves errno as open(2) does when descriptor() is below 0.
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// The caller closes it.
  int descriptor() const { return descriptor_; }

 private:
  int place_ = -1;
  int descriptor_ = -1;
};

/// Whether the path is registered. Also true when more files are open than there are places, since then it is
/// not known.
bool is_unfinished_here(const std::filesystem::path& path);

}  // namespace ringsplat::detail
