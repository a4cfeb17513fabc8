#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "simulate/machine.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat::sort_last {

/// Slices [first, end) of the z axis.
struct Section {
  int first = 0, end = 0;
  int slices() const { return end - first; }
};

/// The section of rank `rank`: as many slices for each as can be.
Section section_of(int rank, int ranks, int slices);
/// The same, where slices cost what `costs` says and sections shall cost the same.
Section section_of(int rank, int ranks, const std::vector<double>& costs);

/// What drawing a section took, besides time.
struct Drawn {
  double splats = 0;
  std::vector<double> costs;  ///< by slice of the volume: seconds on the machine, or in proportion to them
  PixelRect reached;          ///< the part of the picture outside of which it is transparent
};

/// Draws whole pictures of contiguous slices with the renderer's own encoder and painter: what a rank does in
/// sort-last rendering, before pictures are composited.
class SectionPainter {
 public:
  /// Reads the section, and for normals the slices next to it. Seconds of a `machine` are charged to the
  /// simulated clock, each voxel standing for `voxel_weight` of its slice and each pixel for `pixel_weight`.
  SectionPainter(VolumeSource& source, const Section& section, bool with_normals,
                 std::optional<Machine> machine, double voxel_weight, double pixel_weight);

  /// Draws the section into `picture`, of the frame's size and transparent. Throws InputError when the view
  /// does not traverse the z slices.
  Drawn draw(const FrameSpec& spec, Image& picture);

  std::uint64_t slice_memory() const { return store_.allocated_bytes(); }

 private:
  std::shared_ptr<const SplatFrame> frame_of(const FrameSpec& spec) const;
  /// `samples`: pixels that its one Renderer composites.
  double cost_of(const EncodedStep& encoded, double samples) const;

  Grid whole_;
  Section section_;
  std::optional<Machine> machine_;
  double voxel_weight_, pixel_weight_;
  SliceStore store_;
  EmptySpace space_;
  ThreadTeam threads_;
  std::unique_ptr<FramePainter<SplatFrame>> painter_;
};

}  // namespace ringsplat::sort_last
