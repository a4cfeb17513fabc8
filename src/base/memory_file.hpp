#pragma once
#include <cstddef>
#include <filesystem>
#include <span>

namespace ringsplat::detail {

/// A file that exists in memory only and goes with the object. It has a name, for libraries that open files
/// by name. Throws RunError when the system gives none.
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /// Valid in this process while the object lives.
  std::filesystem::path path() const;
  void append(std::span<const std::byte> bytes);

 private:
  int descriptor_ = -1;
};

}  // namespace ringsplat::detail
