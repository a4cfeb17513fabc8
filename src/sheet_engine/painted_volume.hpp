#pragma once
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sheet_engine/block_windows.hpp"
#include "sheet_engine/place_map.hpp"
#include "sheet_engine/projection.hpp"
#include "sheet_engine/scalar_planes.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slab_table.hpp"
#include "sheet_engine/visible_tiles.hpp"

namespace ringsplat {

/// What a Renderer holds of one of the volumes that a frame shows: planes of its slices and tables, which are
/// kept from frame to frame, the slabs that wait to be painted, and what the last payload says of it.
class PaintedVolume {
 public:
  /// Begins a frame of so many volumes. `rays` must outlive it; `owned`: the Renderer's regions.
  void begin_frame(std::shared_ptr<const SheetFrame> frame, const SheetRays& rays,
                   const std::vector<int>& owned, std::size_t volumes);
  /// Makes the frame's tables ahead of its payloads, where frames before have told the volume's range. False
  /// when there is nothing to make.
  bool prepare();
  /// Reads a payload, which must outlive its use. Throws RunError when it is none of the frame's.
  void read(std::span<const std::byte> body, int renderer);
  /// Puts the payload's slice into the planes, as that of a step, or only where it is kept.
  void place(int step) { planes_.place(step, *payload, type(), blocks_seen(step)); }
  void keep() { planes_.keep(*payload, type()); }

  /// Marks the tiles of the last of `tiles`' slabs, the one behind the payload's slice. Returns whether there
  /// are any. `windows`: of its blocks.
  bool mark_tiles(const BlockWindows& windows, int slice);
  /// Gives the first `count` slabs their planes.
  void find_planes(std::size_t count);
  /// Makes what lies behind the last slice.
  void extrapolate_end();

  bool ready() const { return ready_; }
  int slots() const { return planes_.slots(); }
  const SheetFrame& frame() const { return *frame_; }
  const SheetPaint& paint() const { return paint_; }
  /// Valid until the next frame. `last_step`: of the last slice that came.
  ProjectedVolume projected(int last_step);

  VisibleTiles tiles;                   ///< of the slabs
  std::vector<SheetSlab> slabs;         ///< pending ones, front to back
  std::optional<SheetPayload> payload;  ///< none: the step's payload has nothing of the volume

 private:
  const FrameGeometry& geometry() const { return frame_->geometry; }
  ScalarType type() const { return geometry().grid.type; }
  double slab_length() const { return frame_->step_length() / frame_->slabs(); }
  /// The columns and rows of a slice's blocks that the Renderer's pixels may show.
  PixelRect blocks_seen(int step) const;
  void make_ready();
  void make_tints();
  void fill_table();

  std::shared_ptr<const SheetFrame> frame_;
  std::size_t volumes_ = 1;
  const SheetRays* rays_ = nullptr;
  PixelWindow pixels_{};                 ///< of the image plane, with all of the Renderer's in any layer
  std::optional<BlockWindows> windows_;  ///< of all that a block is used for
  ProjectionColours colours_;            ///< where slabs are not composited
  std::optional<std::pair<double, double>> range_;  ///< the volume's values, as last told
  ValueScale scale_;
  SlabTable table_;
  ValueTable values_;  ///< instead, where values are the nearest voxels'
  ScalarPlanes planes_;
  SheetPaint paint_;
  TintTable tints_{};
  bool ready_ = false;  ///< tables and planes are the frame's
};

}  // namespace ringsplat
