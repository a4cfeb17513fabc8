#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

struct stat;

namespace ringsplat::detail {

/// A file's size and the time of its last change: shows whether it was written to.
struct FileStamp {
  std::uint64_t bytes = 0;
  std::int64_t seconds = 0, nanoseconds = 0;
  bool operator==(const FileStamp&) const = default;
};
FileStamp stamp_of(const struct stat& status);
/// Throws InputError when `now` differs from `before`.
void require_same_stamp(const std::filesystem::path& file, const FileStamp& before, const FileStamp& now);

/// A regular file opened for reading at any place (64-bit offsets). Owns the descriptor.
class InputFile {
 public:
  /// Throws InputError when the path is missing, no regular file, or unreadable.
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return stamp_.bytes; }

  /// Reads up to out.size() bytes at `offset`; less only at the end of the file. Throws InputError
  /// when the disk fails.
  std::size_t read_some(std::uint64_t offset, std::span<std::byte> out) const;
  /// Fills `out`; throws InputError when the file ends too early.
  void read(std::uint64_t offset, std::span<std::byte> out) const;
  /// All bytes, read when they are looked at: the system ends a process that looks at what others have cut
  /// off since. The memory may outlive the object.
  std::shared_ptr<const char> mapped() const;
  /// Throws InputError when the file has been written to since it was opened.
  void require_unchanged() const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  FileStamp stamp_;
};

}  // namespace ringsplat::detail
