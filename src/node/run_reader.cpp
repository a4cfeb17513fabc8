#include <fmt/format.h>

#include <algorithm>
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
    row_ = placed_ = nothing;
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
    chunk = {group_.region, 0, 0, {}};
    splats_.resize(most);
    filled_ = 0;
    while (filled_ + chunk.off_screen < most && (run_.count > 0 || (runs_left_ > 0 && next_run()))) {
      const std::uint32_t wanted = std::min<std::uint32_t>(run_.count, most - std::uint32_t(filled_ + chunk.off_screen));
      if (!append_splats(wanted, chunk)) break;
    }
    chunk.base_x = static_cast<std::int32_t>(corner_x_ + base_x_);
    chunk.base_y = static_cast<std::int32_t>(corner_y_ + base_y_);
    chunk.splats = std::as_bytes(std::span(splats_).first(filled_));
    return true;
  }

 private:
  /// Places the columns round the run's first voxel, unless they are placed: runs are short, and rows have several.
  void place_block() {
    const std::uint32_t first = run_.first / RunPlaces::capacity * RunPlaces::capacity;
    if (std::exchange(placed_, first) == first) return;
    const int count = int(std::min<std::uint32_t>(RunPlaces::capacity, width_ - first));
    place_run(geometry_.footprint, dda_, first, count, corner_x_, corner_y_, places_);
  }

  /// Appends at most `wanted` of the run's voxels; false when the next one needs another base.
  ///
  /// Bases lie on a lattice of 256 pixels that begins before the region's corner by the kernels' reach, so that regions
  /// of up to 250 pixels have one.
  bool append_splats(std::uint32_t wanted, SplatChunk& chunk) {
    place_block();
    const std::uint32_t first = run_.first - placed_, end = std::min<std::uint32_t>(first + wanted, RunPlaces::capacity);
    std::uint32_t k = first;
    for (; k < end; ++k) {
      const std::int32_t x = places_.anchor_x[k], y = places_.anchor_y[k];
      if (is_far(x) || is_far(y)) {
        ++chunk.off_screen;
        continue;
      }
      if (filled_ == 0) {
        base_x_ = x & ~255;
        base_y_ = y & ~255;
      } else if ((x & ~255) != base_x_ || (y & ~255) != base_y_) {
        break;
      }
      Voxel voxel;
      std::memcpy(&voxel, body_.data() + voxel_at_ + (k - first) * sizeof voxel, sizeof voxel);
      const VoxelColour colour = unpack(voxel);
      splats_[filled_++] = {places_.a[k], places_.b[k], places_.c[k], weighted_opacity(geometry_.footprint, colour.opacity),
                            colour.red, colour.green, colour.blue, static_cast<std::uint8_t>(x & 255), static_cast<std::uint8_t>(y & 255)};
    }
    voxel_at_ += (k - first) * sizeof(Voxel);
    run_.first += k - first;
    run_.count -= k - first;
    return k == end;
  }

  /// No kernel reaches so far.
  static bool is_far(std::int32_t anchor) { return anchor > (1 << 30) || anchor < -(1 << 30); }

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
      placed_ = nothing;
      voxel_at_ = at_ + group_.runs * sizeof(VoxelRun);
      group_end_ = voxel_at_ + group_.voxels * sizeof(Voxel);
    }
    if (!take(body_, at_, run_)) return false;
    --runs_left_;
    if (std::exchange(row_, run_.row) != run_.row) {
      dda_.begin_row(slice_, int(run_.row));
      placed_ = nothing;
    }
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
  static constexpr std::uint32_t nothing = ~0U;
  std::uint32_t row_ = nothing;     ///< that the DDA is at
  std::uint32_t placed_ = nothing;  ///< first of the columns in places_
  VoxelRun run_{};  ///< what is left of the run
  RunPlaces places_;
  std::int32_t base_x_ = 0, base_y_ = 0;  ///< of the chunk, from the corner
  std::vector<Splat> splats_;
  std::size_t filled_ = 0;  ///< of splats_
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
