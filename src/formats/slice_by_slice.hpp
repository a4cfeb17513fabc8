#pragma once
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "formats/volume_files.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

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
