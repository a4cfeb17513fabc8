#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "engine_parts/frame_engine.hpp"
#include "sheet_engine/transparent_values.hpp"

namespace ringsplat {

struct SheetFrame : SharedFrame {
  using SharedFrame::SharedFrame;

  Sheets sheets;
  TransparentValues transparent;
  /// Frames of other volumes that are painted along the same rays, all alike but for the volume and its
  /// transfer function.
  std::vector<std::shared_ptr<const SheetFrame>> others;

  bool shaded() const { return shown.shading == Shading::phong && !shown.values; }
  /// Whether colours or opacities go by gradients.
  bool lit() const {
    return shaded() ? composites() || shown.mode == Mode::surface : composites() && shown.edges;
  }
  /// Whether labels tint what is shown: slabs, or the place of a single slice.
  bool tinted() const { return !shown.tints.empty() && (composites() || geometry.slices == 1); }
  bool composites() const { return shown.mode == Mode::composite; }
  /// Whether rays that meet only holes must be told from those of the least value: nothing is transparent.
  bool tells_holes() const {
    return (shown.mode == Mode::mip || shown.mode == Mode::minip) && transparent.intervals().empty();
  }
  /// Whether slabs count by their lengths, and not all alike.
  bool by_length() const { return shown.opacity_correction || !composites(); }
  /// A ray's length from slice to slice, in unit lengths.
  double step_length() const {
    return by_length() ? geometry.traversal.slice_distance : double(shown.reduction.factor);
  }
  /// The unit length in world lengths; a reduced grid's spacings are multiples of it.
  double unit_length() const { return geometry.grid.unit_length() / shown.reduction.factor; }
  bool nearest() const { return shown.interpolation == Interpolation::nearest; }
  /// From slice to slice. Nearest values change half-way, where one must end.
  int slabs() const {
    if (!composites()) return 1;
    const int slabs = geometry.traversal.slabs_for(sheets.slabs);
    return nearest() ? slabs + slabs % 2 : slabs;
  }
  /// Beyond the first and the last slice's centre.
  int slabs_in_half() const { return nearest() ? slabs() / 2 : Traversal::slabs_in_half(slabs()); }
  /// Slices to either side that are drawn with a slice's voxels: those that the slabs at it lie between, and
  /// for gradients one more.
  int reach() const { return lit() ? 2 : 1; }
};

/// A frame and its others.
inline std::vector<std::shared_ptr<const SheetFrame>> channels_of(std::shared_ptr<const SheetFrame> frame) {
  auto all = frame->others;
  all.insert(all.begin(), std::move(frame));
  return all;
}

/// `spec` must be of this method; without a `dealer` regions are dealt in turn. Throws InputError when its
/// view cannot be drawn.
std::shared_ptr<const SheetFrame> make_sheet_frame(const FrameSpec& spec, const Grid& grid,
                                                   SliceDealing dealing, int renderers,
                                                   RegionDealer* dealer = nullptr);

/// Whether these frames, of volumes on one grid, are drawn as one: projections of one value a pixel, or
/// materials, that differ in their transfer functions alone.
bool drawn_together(const std::vector<FrameOfVolume>& frames);
/// The first of `frames`, made, with the others that it is drawn with. Throws RunError where they are not
/// drawn as one.
std::shared_ptr<const SheetFrame> with_others(std::shared_ptr<const SheetFrame> first,
                                              const std::vector<FrameOfVolume>& frames);

}  // namespace ringsplat
