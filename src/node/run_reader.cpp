#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "node/payload_reader.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/voxel_run.hpp"
#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// Makes the same splats of runs that the GP would have made of the voxels.
template <class Voxel>
class RunReader final : public PayloadReader {
 public:
  RunReader(const FrameGeometry& geometry, const Grid& grid)
      : geometry_(geometry),
        width_(std::uint32_t(grid.slice_width(geometry.traversal.axis))),
        height_(std::uint32_t(grid.slice_height(geometry.traversal.axis))),
        dda_(geometry.view, geometry.traversal.axis, int(width_)) {}

  void begin(int slice, std::span<const std::byte> body, const std::function<bool(int)>& owned) override {
    slice_ = slice;
    body_ = body;
    at_ = group_end_ = 0;
    runs_left_ = 0;
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
    // A base well before the first anchor leaves room on both sides for those that follow.
    constexpr std::int64_t room = 128;
    bool based = false;
    while (splats_.size() + chunk.off_screen < most && (run_.count > 0 || (runs_left_ > 0 && next_run()))) {
      const glm::dvec3 position = dda_.position(run_.first);
      const Anchored at = anchor(position.x, position.y);
      if (!based) {
        const auto fit = [](std::int64_t pixel) {
          return static_cast<std::int32_t>(
              std::clamp<std::int64_t>(pixel - room, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()));
        };
        chunk.base_x = fit(at.anchor_x);
        chunk.base_y = fit(at.anchor_y);
      }
      const std::int64_t dx = at.anchor_x - chunk.base_x, dy = at.anchor_y - chunk.base_y;
      const bool fits = dx >= 0 && dx <= 255 && dy >= 0 && dy <= 255;
      if (!fits && based) break;
      Voxel voxel;
      std::memcpy(&voxel, body_.data() + voxel_at_, sizeof voxel);
      if (fits)
        splats_.push_back(make_splat(at, unpack(voxel), static_cast<std::uint8_t>(dx), static_cast<std::uint8_t>(dy)));
      else
        ++chunk.off_screen;
      based = fits;
      voxel_at_ += sizeof voxel;
      ++run_.first;
      --run_.count;
    }
    chunk.splats = std::as_bytes(std::span(splats_));
    return true;
  }

 private:
  Splat make_splat(const Anchored& at, const VoxelColour& colour, std::uint8_t dx, std::uint8_t dy) const {
    const Coefficients q = coefficients(geometry_.footprint, at.dx, at.dy);
    return {static_cast<float>(q.a), static_cast<float>(q.b), static_cast<float>(q.c),
            weighted_opacity(geometry_.footprint, colour.opacity), colour.red, colour.green, colour.blue, dx, dy};
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
      voxel_at_ = at_ + group_.runs * sizeof(VoxelRun);
      group_end_ = voxel_at_ + group_.voxels * sizeof(Voxel);
    }
    if (!take(body_, at_, run_)) return false;
    --runs_left_;
    dda_.begin_row(slice_, int(run_.row));
    return true;
  }

  const FrameGeometry& geometry_;
  std::uint32_t width_, height_;
  SliceDda dda_;
  int slice_ = 0;
  std::span<const std::byte> body_;
  std::size_t at_ = 0, voxel_at_ = 0, group_end_ = 0;  ///< bytes into the body: the next run, the next voxel, the next group
  RunGroup group_{};
  std::uint32_t runs_left_ = 0;
  VoxelRun run_{};  ///< what is left of the run
  std::vector<Splat> splats_;
};

}  // namespace

std::unique_ptr<PayloadReader> make_run_reader(const FrameSpec& spec, const FrameGeometry& geometry, const Grid& grid) {
  switch (spec.precision) {
    case Precision::half: return std::make_unique<RunReader<HalfVoxel>>(geometry, grid);
    case Precision::u8: return std::make_unique<RunReader<ByteVoxel>>(geometry, grid);
    case Precision::float32: break;
  }
  return std::make_unique<RunReader<FloatVoxel>>(geometry, grid);
}

}  // namespace ringsplat
