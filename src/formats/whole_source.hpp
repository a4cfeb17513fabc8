#pragma once
#include <span>
#include <vector>

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

}  // namespace ringsplat::detail
