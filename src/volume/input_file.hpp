#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace ringsplat::detail {

/// A regular file opened for reading at any place (64-bit offsets). Owns the descriptor.
class InputFile {
 public:
  /// Throws InputError when the path is missing, no regular file, or unreadable.
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Reads up to out.size() bytes at `offset`; less only at the end of the file. Throws InputError
  /// when the disk fails.
  std::size_t read_some(std::uint64_t offset, std::span<std::byte> out) const;
  /// Fills `out`; throws InputError when the file ends before.
  void read(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace ringsplat::detail
