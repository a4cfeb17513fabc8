#pragma once
#include <cstddef>
#include <filesystem>
#include <span>

namespace ringsplat::detail {

/// A file that exists in memory only and is gone with the object; libraries that want a name can open it by
/// one. Throws RunError when the system gives none.
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept;
  MemoryFile& operator=(MemoryFile&&) = delete;

  /// Valid in this process while the object lives.
  std::filesystem::path path() const;
  void append(std::span<const std::byte> bytes);

 private:
  int descriptor_ = -1;
};

}  // namespace ringsplat::detail
