#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "raster/opaque_tiles.hpp"
#include "splat/aligned_slice.hpp"
#include "splat/frame_kernel.hpp"
#include "splat/splat.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {

struct DrawCounts {
  std::uint64_t drawn = 0;    ///< splats that reached at least one pixel centre of the region with Q > 0
  std::uint64_t clipped = 0;  ///< splats that reached none
  std::uint64_t hidden = 0;   ///< splats that lie wholly under opaque tiles, not drawn
};

struct DrawnBlocks {
  std::uint32_t blocks = 0;  ///< gone through
  DrawCounts counts;         ///< of their voxels
};

/// The memory of one slice buffer. Painters that share one must be used one after the other, each with
/// composite() before the next one draws: so the buffer stays in the processor's cache. Painters that do not
/// share one may be used by several threads at once.
class SliceMemory;
std::shared_ptr<SliceMemory> make_slice_memory();

/// One region's slice buffer and image (Westover 1989; Neumann 1992, section 2.3).
///
/// The slice buffer sums the splats of one slice; composite() puts it behind the image and empties it.
/// Colours are premultiplied; the image keeps colour and opacity. A pixel's sum runs in the order of
/// the splats given, with the same operations whatever the vector width, so its bits do not depend on the
/// processor, the region size or the other splats.
///
/// A pixel whose transmittance has fallen below `opaque_threshold` takes nothing more. That is decided pixel
/// by pixel from the slices before, so a splat that lies wholly under such pixels may be left out by anyone
/// who knows of them, at any time, and the image keeps its bits.
class RegionPainter {
 public:
  /// Region of width × height pixels whose corner is screen pixel (x0, y0). No pixels are allocated before
  /// the first splat. Throws InputError for a size below 1.
  RegionPainter(int x0, int y0, int width, int height,
                std::shared_ptr<SliceMemory> memory = make_slice_memory());
  ~RegionPainter();
  RegionPainter(RegionPainter&&) noexcept;
  RegionPainter& operator=(RegionPainter&&) noexcept;

  /// From now on sums slices into `memory`. Only while it holds none of this painter's: after composite() or
  /// begin_frame().
  void use(std::shared_ptr<SliceMemory> memory);

  /// Forgets the last frame's image and takes the frame's kernel.
  void begin_frame(const FrameKernel& kernel, float opaque_threshold = 0);
  /// The same for kernels that are computed in float32 and not normalised any further.
  void begin_frame(const Footprint& footprint, float opaque_threshold = 0) {
    begin_frame(FrameKernel{footprint, 0, {}, {}}, opaque_threshold);
  }
  /// Sums splats into the slice buffer. `bytes` is count × sizeof(Splat), any alignment.
  /// Splats with a NaN or a coefficient that no footprint can have are counted as clipped.
  DrawCounts draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats);
  /// Takes voxels of the slice, which composite() will sum: the same bits as draw() of their splats, row by
  /// row, gives. Each voxel of a slice once; not together with draw() in one slice. Stops after `most` voxels
  /// or the block in which they end. `slice` must stay as it is until composite(). For FloatVoxel, HalfVoxel
  /// and ByteVoxel.
  template <class Voxel>
  DrawnBlocks draw_blocks(const AlignedSlice& slice, const VoxelBlocks<Voxel>& blocks, std::uint64_t most);
  /// Puts the slice behind the image: C += (1 − A) c, A += (1 − A) a, with a and c clamped to [0, 1] and [0,
  /// a]; empties the slice buffer. Costs nothing when no splat was drawn since the last call. `voxel`: where
  /// a voxel of the slice lies on the screen; only the exact normalisation asks, and divides a and c first.
  void composite(glm::dvec2 voxel = glm::dvec2(0.0));
  /// Which tiles take nothing more in this frame. Brought up to date every few slices.
  const OpaqueTiles& opaque_tiles() const;
  /// False when nothing was drawn since begin_frame: the region is empty.
  bool touched() const;
  /// Writes width × height premultiplied RGBA floats, rows from the top; transparent when
  /// untouched. Throws InputError when `rgba` has another size.
  void read_tile(std::span<float> rgba) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ringsplat
