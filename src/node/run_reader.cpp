#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "node/payload_reader.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/place_run.hpp"
#include "ringsplat/splat/voxel_run.hpp"
#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// Makes the same splats of runs that the GP would have made of the voxels.
template <class Voxel>
class RunReader final : public PayloadReader {
 public:
  RunReader(const FrameGeometry& geometry)
      : geometry_(geometry),
        width_(std::uint32_t(geometry.grid.slice_width(geometry.traversal.axis))),
        height_(std::uint32_t(geometry.grid.slice_height(geometry.traversal.axis))),
        dda_(geometry.view, geometry.traversal.axis, int(width_)) {}

  void begin(int slice, std::span<const std::byte> body, const std::function<bool(int)>& owned) override {
    slice_ = slice;
    body_ = body;
    at_ = group_end_ = 0;
    runs_left_ = 0;
    row_ = ~0U;
    run_ = {};
    int last = -1;
    for (std::size_t at = 0; at < body.size();) {
      RunGroup group;
      if (!take(body, at, group) || group.region <= last || !owned(group.region) || !check_runs(group, at))
        throw RunError(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at),
                       "all ranks must run the same build");
      last = group.region;
    }
  }

  bool next(std::uint32_t most, SplatChunk& chunk) override {
    if (run_.count == 0 && !next_run()) return false;
    splats_.clear();
    chunk = {group_.region, 0, 0, {}};
    bool based = false;
    while (splats_.size() + chunk.off_screen < most && (run_.count > 0 || (runs_left_ > 0 && next_run()))) {
      const Piece piece = next_piece();
      if (!piece.on_screen()) {
        chunk.off_screen += piece.count;
      } else {
        if (based && (chunk.base_x != piece.base_x || chunk.base_y != piece.base_y)) break;
        based = true;
        chunk.base_x = static_cast<std::int32_t>(piece.base_x);
        chunk.base_y = static_cast<std::int32_t>(piece.base_y);
        append_splats(piece);
      }
      voxel_at_ += piece.count * sizeof(Voxel);
      run_.first += piece.count;
      run_.count -= piece.count;
    }
    chunk.splats = std::as_bytes(std::span(splats_));
    return true;
  }

 private:
  /// The first voxels of a run whose anchors lie within 256 × 256 pixels from one base.
  struct Piece {
    std::uint32_t count;
    std::int64_t base_x, base_y;
    bool on_screen() const {
      constexpr std::int64_t far = std::int64_t{1} << 30;
      return std::abs(base_x) < far && std::abs(base_y) < far;
    }
  };

  /// Bases lie on a lattice of 256 pixels that begins before the region's corner by the kernels' reach, so that regions
  /// of up to 250 pixels have one. Anchors are monotone along a run: its ends tell.
  Piece next_piece() const {
    const Piece front = base_of(run_.first);
    std::uint32_t count = std::min<std::uint32_t>(run_.count, RunPlaces::capacity);
    for (; count > 1; count = (count + 1) / 2) {
      const Piece back = base_of(run_.first + count - 1);
      if (back.base_x == front.base_x && back.base_y == front.base_y) break;
      if (count == 2) return front;
    }
    return {count, front.base_x, front.base_y};
  }

  Piece base_of(std::uint32_t column) const {
    const glm::dvec3 position = dda_.position(column);
    const auto base = [](std::int64_t pixel, std::int64_t corner) { return corner + ((pixel - corner) & ~std::int64_t{255}); };
    return {1, base(anchor_pixel(position.x), corner_x_), base(anchor_pixel(position.y), corner_y_)};
  }

  void append_splats(const Piece& piece) {
    const Footprint& footprint = geometry_.footprint;
    place_run(footprint, dda_, run_.first, int(piece.count), piece.base_x, piece.base_y, places_);
    const std::size_t first = splats_.size();
    splats_.resize(first + piece.count);
    for (std::size_t k = 0; k < piece.count; ++k) {
      Voxel voxel;
      std::memcpy(&voxel, body_.data() + voxel_at_ + k * sizeof voxel, sizeof voxel);
      const VoxelColour colour = unpack(voxel);
      splats_[first + k] = {places_.a[k], places_.b[k], places_.c[k], weighted_opacity(footprint, colour.opacity),
                            colour.red, colour.green, colour.blue, static_cast<std::uint8_t>(places_.anchor_x[k]),
                            static_cast<std::uint8_t>(places_.anchor_y[k])};
    }
  }

  /// Moves `at` behind the group; false when it is not whole or a run leaves the slice.
  bool check_runs(const RunGroup& group, std::size_t& at) const {
    if (group.runs == 0 || (body_.size() - at) / sizeof(VoxelRun) < group.runs) return false;
    std::uint64_t voxels = 0;
    for (std::uint32_t k = 0; k < group.runs; ++k) {
      VoxelRun run;
      if (!take(body_, at, run) || run.row >= height_ || run.first >= width_ || run.count == 0 || run.count > width_ - run.first) return false;
      voxels += run.count;
    }
    if (voxels != group.voxels || (body_.size() - at) / sizeof(Voxel) < group.voxels) return false;
    at += group.voxels * sizeof(Voxel);
    return true;
  }

  /// Goes to the next run, of the next group when this one has no more; false at the end.
  bool next_run() {
    if (runs_left_ == 0) {
      at_ = std::max(at_, group_end_);
      if (!take(body_, at_, group_)) return false;
      runs_left_ = group_.runs;
      const PixelRect rect = geometry_.regions.rect(group_.region);
      const KernelReach reach = kernel_reach(geometry_.footprint);
      corner_x_ = rect.x0 - reach.x - 1;
      corner_y_ = rect.y0 - reach.y - 1;
      voxel_at_ = at_ + group_.runs * sizeof(VoxelRun);
      group_end_ = voxel_at_ + group_.voxels * sizeof(Voxel);
    }
    if (!take(body_, at_, run_)) return false;
    --runs_left_;
    if (std::exchange(row_, run_.row) != run_.row) dda_.begin_row(slice_, int(run_.row));
    return true;
  }

  const FrameGeometry& geometry_;
  std::uint32_t width_, height_;
  SliceDda dda_;
  int slice_ = 0;
  std::span<const std::byte> body_;
  std::size_t at_ = 0, voxel_at_ = 0, group_end_ = 0;  ///< bytes into the body: the next run, the next voxel, the next group
  RunGroup group_{};
  std::int64_t corner_x_ = 0, corner_y_ = 0;  ///< where the bases' lattice begins
  std::uint32_t runs_left_ = 0;
  std::uint32_t row_ = ~0U;  ///< that the DDA is at
  VoxelRun run_{};  ///< what is left of the run
  RunPlaces places_;
  std::vector<Splat> splats_;
};

}  // namespace

std::unique_ptr<PayloadReader> make_run_reader(const FrameSpec& spec, const FrameGeometry& geometry) {
  switch (spec.precision) {
    case Precision::half: return std::make_unique<RunReader<HalfVoxel>>(geometry);
    case Precision::u8: return std::make_unique<RunReader<ByteVoxel>>(geometry);
    case Precision::float32: break;
  }
  return std::make_unique<RunReader<FloatVoxel>>(geometry);
}

}  // namespace ringsplat
