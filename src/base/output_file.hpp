#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace ringsplat {

class TemporaryFile;

/// A file that appears under its name only when all of it is on the disk. Until then its bytes are in a file
/// without a name, or, where the disk has no such files, in a hidden one beside it (docs/formats.md,
/// "Files"), and a file that had the name before stays as it was. The user's own symbolic links are followed.
///
/// Every function may throw RunError, which names the file and the system's reason. One thread at a time.
class OutputFile {
 public:
  /// Makes the hidden file, in a folder that must exist.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }  ///< bytes so far

  /// Appends.
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }

  /// Proves that all bytes are on the disk: flushed, of the right size, closed. Nothing can be written after
  /// it.
  void secure();
  /// secure(), then gives the file its name. Secure all files that belong together before you commit the
  /// first.
  void commit();

 private:
  [[noreturn]] void fail(int reason) const;

  std::filesystem::path path_;
  std::unique_ptr<TemporaryFile> file_;
  std::uint64_t size_ = 0;
  bool secured_ = false;
};

/// A whole text file. Throws RunError as OutputFile does.
void write_text(const std::filesystem::path& path, const std::string& text);

/// Checks that a file can be made at `path`: its folder exists and can be written, and `path` is neither a
/// folder nor a device. Else throws InputError naming `option`, or RunError when the disk fails. Leaves
/// nothing behind.
void check_can_write(const std::filesystem::path& path, const std::string& option);

}  // namespace ringsplat
