#pragma once
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/input_file.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat::detail {

/// Adds a file's size, and hashes of the first and the last of the `bytes` bytes from `offset` on: up to 64
/// KiB each. Throws InputError when the file cannot be read.
void add_facts_of(const InputFile& file, std::uint64_t offset, std::uint64_t bytes, Facts& facts);

/// The files of a volume that other code than InputFile reads, as they were when this was made.
class VolumeFiles {
 public:
  /// `files`: in the order of the slices; a file several times in a row counts once. Throws InputError when
  /// one cannot be read.
  explicit VolumeFiles(const std::vector<std::filesystem::path>& files);
  /// Throws InputError when the file has changed or is gone. Call it before a file is opened again and after
  /// it was read.
  void require_unchanged(const std::filesystem::path& file) const;
  /// Their number, names without folders, sizes, and hashes of their first and last bytes.
  Facts facts() const;

 private:
  std::vector<std::filesystem::path> files_;
  std::unordered_map<std::string, FileStamp> stamps_;  ///< by path
};

}  // namespace ringsplat::detail
