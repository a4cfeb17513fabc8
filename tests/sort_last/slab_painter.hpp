#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "model/machine.hpp"
#include "ringsplat/volume/source.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat::sort_last {

/// Slices [first, end) of the z axis.
struct Slab {
  int first = 0, end = 0;
  int slices() const { return end - first; }
};

/// The slab of rank `rank`: as many slices for each as can be.
Slab slab_of(int rank, int ranks, int slices);
/// The same, where slices cost what `costs` says and slabs shall cost the same.
Slab slab_of(int rank, int ranks, const std::vector<double>& costs);

/// What drawing a slab took, besides time.
struct Drawn {
  double splats = 0;
  std::vector<double> costs;  ///< by slice of the volume: seconds on the machine, or in proportion to them
  PixelRect reached;          ///< the part of the picture outside of which it is transparent
};

/// Draws whole pictures of contiguous slices with the renderer's own encoder and painter: what a rank does in
/// sort-last rendering, before pictures are composited.
class SlabPainter {
 public:
  /// Reads the slab, and for normals the slices next to it. Seconds of a `machine` are charged to the
  /// simulated clock, each voxel standing for `voxel_weight` of its slice and each pixel for `pixel_weight`.
  SlabPainter(VolumeSource& source, const Slab& slab, bool with_normals, std::optional<Machine> machine,
              double voxel_weight, double pixel_weight);

  /// Draws the slab into `picture`, of the frame's size and transparent. Throws InputError when the view does
  /// not traverse the z slices.
  Drawn draw(const FrameSpec& spec, Image& picture);

  std::uint64_t slice_memory() const { return store_.allocated_bytes(); }

 private:
  std::shared_ptr<const SplatFrame> frame_of(const FrameSpec& spec) const;
  double cost_of(const EncodedStep& step) const;

  Grid whole_;
  Slab slab_;
  std::optional<Machine> machine_;
  double voxel_weight_, pixel_weight_;
  SliceStore store_;
  EmptySpace space_;
  ThreadTeam threads_;
  std::unique_ptr<FramePainter<SplatFrame>> painter_;
};

}  // namespace ringsplat::sort_last
