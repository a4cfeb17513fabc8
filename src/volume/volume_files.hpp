#pragma once
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "ringsplat/base/fact.hpp"
#include "volume/input_file.hpp"

namespace ringsplat::detail {

/// Adds a file's size, and hashes of the first and the last of the `bytes` bytes from `offset` on: up to 64
/// KiB each. Throws InputError when the file cannot be read.
void add_facts_of(const InputFile& file, std::uint64_t offset, std::uint64_t bytes, Facts& facts);

/// The files that a volume is read from by others than InputFile, as they were when this was made.
class VolumeFiles {
 public:
  /// In the order of the slices; a file that comes several times in a row counts once. Throws InputError when
  /// one cannot be read.
  explicit VolumeFiles(const std::vector<std::filesystem::path>& files);
  /// For before a file is opened again and after it was read. Throws InputError when it has changed or is
  /// gone.
  void require_unchanged(const std::filesystem::path& file) const;
  /// Their number, names without folders, sizes, and hashes of their first and last bytes.
  Facts facts() const;

 private:
  std::vector<std::filesystem::path> files_;
  std::unordered_map<std::string, FileStamp> stamps_;  ///< by path
};

}  // namespace ringsplat::detail
