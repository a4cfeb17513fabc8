#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/engine.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "screen/regions.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::sort_last {

/// Slices [first, end) of an axis.
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
  double items = 0;           ///< splats, or blocks of sheets
  double seconds = 0;         ///< on the machine, of what was not charged yet
  std::vector<double> costs;  ///< by slice of the volume: seconds on the machine, or in proportion to them
  PixelRect reached;          ///< the part of the picture outside of which it is transparent
};

/// Draws whole pictures of contiguous slices with the renderer's own encoder and painter: what a rank does in
/// sort-last rendering, before pictures are composited.
class SectionPainter {
 public:
  virtual ~SectionPainter() = default;
  /// Draws the section into `picture`, of the frame's size and transparent. Throws InputError when the view
  /// does not traverse the section's slices.
  virtual Drawn draw(const FrameSpec& spec, Image& picture) = 0;
  virtual std::uint64_t slice_memory() const = 0;
};

/// What a section is of, and what drawing it costs. Seconds of a machine are charged to the simulated clock,
/// each voxel standing for `voxel_weight` of its slice and each pixel for `pixel_weight`.
struct SectionSetup {
  VolumeSource& source;
  Section section;
  std::optional<Machine> machine;
  double voxel_weight = 1, pixel_weight = 1;
};

/// Of z slices, drawn by splats. Reads the section, and for normals the slices next to it.
std::unique_ptr<SectionPainter> make_splat_section(const SectionSetup& setup, bool with_normals);

/// Of slices of `axis`, drawn by sheets: from each of them on to the one that rays meet next, so that no ray
/// goes through anything twice. The slices that this and gradients need besides are read, too; what is read
/// is kept ready to be drawn from one frame to the next. The whole volume's values lie between `low` and
/// `high`. Voxels stand for themselves.
std::unique_ptr<SectionPainter> make_sheet_section(const SectionSetup& setup, Axis axis, double low,
                                                   double high);

/// Puts a painter's finished tiles of `regions` into the picture and notes what they cover and cost.
void finish(Painter& painter, const Regions& regions, const SectionSetup& setup, Image& picture,
            Drawn& drawn);

}  // namespace ringsplat::sort_last
