#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "ringsplat/base/fact.hpp"
#include "ringsplat/volume/source.hpp"

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

/// A volume whose z slices are read one by one, from files or pages of their own, so that every process reads
/// its own.
class SliceBySlice : public VolumeSource {
 public:
  /// `encoding`: facts beside the grid's and the files'.
  SliceBySlice(const Grid& grid, const std::vector<std::filesystem::path>& files, Facts encoding)
      : grid_(grid), files_(files), encoding_(std::move(encoding)) {}
  const Grid& grid() const final { return grid_; }
  bool concurrent() const final { return true; }
  void read_slices(int first, int count, std::span<std::byte> out) final {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int z = first; z < first + count; ++z)
      read_slice(z, out.subspan(std::size_t(z - first) * bytes, bytes));
  }
  Facts facts() const final {
    Facts facts = encoding_;
    const Facts of_files = files_.facts();
    facts.insert(facts.end(), of_files.begin(), of_files.end());
    return facts;
  }

 protected:
  /// Throws InputError when a file is no longer what it was when the volume was opened.
  void require_unchanged(const std::filesystem::path& file) const { files_.require_unchanged(file); }

 private:
  virtual void read_slice(int z, std::span<std::byte> out) = 0;

  Grid grid_;
  VolumeFiles files_;
  Facts encoding_;
};

}  // namespace ringsplat::detail
