#pragma once
#include <map>
#include <optional>
#include <vector>

#include "ringsplat/net/layout.hpp"
#include "scene/scene.hpp"
#include "scene/voxel_blocks.hpp"
#include "session/render.hpp"

namespace ringsplat {

/// A volume that processes have put together from their blocks. GPs keep its z slices; what frames need
/// besides is made of them when it is first needed. All calls are collective, with the same arguments but for
/// the blocks.
class SharedVolume {
 public:
  /// The wiring's parts must outlive it.
  SharedVolume(const Layout& layout, const Wiring& wiring) : layout_(layout), wiring_(wiring) {}

  /// Takes the voxels of all processes' blocks in place of the volume before. Throws the same InputError on
  /// all when grids, layouts or blocks do not fit; then the volume stays as it was.
  void replace(const Grid& grid, const std::vector<VoxelBlock>& blocks);

  /// Nothing before the first replace().
  const std::optional<Grid>& grid() const { return grid_; }
  const ValueStatistics& values();
  /// What frames need that need all this.
  Scene scene_for(const LoadOptions& needed);

 private:
  Layout layout_;
  Wiring wiring_;
  std::optional<Grid> grid_;
  std::map<int, SliceStore> slices_;  ///< along z
  std::optional<ValueStatistics> values_;
  LoadOptions made_;  ///< the scene's
  std::optional<Scene> scene_;
};

}  // namespace ringsplat
