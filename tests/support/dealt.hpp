#pragma once
#include <map>
#include <vector>

#include "scene/scene.hpp"
#include "support/memory_source.hpp"
#include "volume/synth.hpp"

namespace ringsplat::test {

/// All GPs' slices of a volume, with what is known of their values.
inline std::map<int, SliceStore> dealt(VolumeSource& source, int gps) {
  SoloCollectives solo;
  const Grid grid = source.grid();
  std::vector<std::byte> voxels(grid.bytes());
  source.read_slices(0, grid.dims.z, voxels);
  OpenedVolume volume{grid, true, memory_source(grid, voxels)};
  auto stores = deal_slices(volume, {}, {gps, std::vector<int>(std::size_t(gps)), solo});
  share_slice_ranges(stores, solo);
  return stores;
}

/// The slices of one GP, with what sheets need of their cells too.
inline std::map<int, SliceStore> dealt_for_sheets(VolumeSource& source) {
  auto stores = dealt(source, 1);
  SoloCollectives solo;
  share_cell_ranges(stores, {1, {0}, solo});
  return stores;
}

}  // namespace ringsplat::test
