#pragma once
#include <filesystem>
#include <span>
#include <vector>

#include "formats/volume_files.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// A source that can only be decoded as a whole: the first read keeps the whole volume. Not concurrent.
class WholeSource : public VolumeSource {
 public:
  explicit WholeSource(const Grid& grid) : grid_(grid) {}
  const Grid& grid() const final { return grid_; }
  bool concurrent() const final { return false; }
  void read_slices(int first, int count, std::span<std::byte> out) final;

 private:
  /// Fills `voxels`, grid().bytes() of them, in native order. A throw leaves nothing kept.
  virtual void decode(std::span<std::byte> voxels) = 0;

  Grid grid_;
  std::vector<std::byte> voxels_;  ///< empty until they are first read
};

/// The same of a single file, which must not change meanwhile.
class WholeFileSource : public WholeSource {
 public:
  WholeFileSource(const Grid& grid, const std::filesystem::path& path)
      : WholeSource(grid), path_(path), files_({path}) {}
  Facts facts() const final;

 protected:
  const std::filesystem::path path_;

 private:
  void decode(std::span<std::byte> voxels) final;
  virtual void decode_file(std::span<std::byte> voxels) = 0;

  VolumeFiles files_;
};

}  // namespace ringsplat::detail
