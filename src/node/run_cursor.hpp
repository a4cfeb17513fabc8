#pragma once
#include <fmt/format.h>

#include <functional>
#include <span>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {

/// Goes through a payload of runs, run by run.
template <class Voxel>
class RunCursor {
 public:
  /// `width`, `height`: of the slice, in voxels.
  RunCursor(int width, int height) : width_(std::uint32_t(width)), height_(std::uint32_t(height)) {}

  /// Throws RunError when `body` is no payload of runs in such a slice for regions, ascending, that `owned`
  /// is true of.
  void begin(std::span<const std::byte> body, const std::function<bool(int)>& owned) {
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

  /// Goes to a run with voxels left, of the next group when this one has no more; false at the end.
  bool find() {
    if (run_.count > 0) return true;
    if (runs_left_ == 0) {
      at_ = std::max(at_, group_end_);
      if (!take(body_, at_, group_)) return false;
      runs_left_ = group_.runs;
      voxel_at_ = at_ + group_.runs * sizeof(VoxelRun);
      group_end_ = voxel_at_ + group_.voxels * sizeof(Voxel);
    }
    --runs_left_;
    return take(body_, at_, run_);
  }
  int region() const { return group_.region; }
  /// What is left of the run.
  const VoxelRun& run() const { return run_; }
  /// True when find() will not leave the group.
  bool more_in_group() const { return run_.count > 0 || runs_left_ > 0; }
  Voxel voxel(std::uint32_t k) const {
    Voxel voxel;
    std::memcpy(&voxel, body_.data() + voxel_at_ + k * sizeof voxel, sizeof voxel);
    return voxel;
  }
  void skip(std::uint32_t voxels) {
    voxel_at_ += voxels * sizeof(Voxel);
    run_.first += voxels;
    run_.count -= voxels;
  }

 private:
  /// Moves `at` behind the group; false when it is not whole or a run leaves the slice.
  bool check_runs(const RunGroup& group, std::size_t& at) const {
    if (group.runs == 0 || (body_.size() - at) / sizeof(VoxelRun) < group.runs) return false;
    std::uint64_t voxels = 0;
    for (std::uint32_t k = 0; k < group.runs; ++k) {
      VoxelRun run;
      if (!take(body_, at, run) || run.row >= height_ || run.first >= width_ || run.count == 0 ||
          run.count > width_ - run.first)
        return false;
      voxels += run.count;
    }
    if (voxels != group.voxels || (body_.size() - at) / sizeof(Voxel) < group.voxels) return false;
    at += group.voxels * sizeof(Voxel);
    return true;
  }

  std::uint32_t width_, height_;
  std::span<const std::byte> body_;
  std::size_t at_ = 0, voxel_at_ = 0,
              group_end_ = 0;  ///< bytes into the body: the next run, the next voxel, the next group
  RunGroup group_{};
  std::uint32_t runs_left_ = 0;
  VoxelRun run_{};
};

}  // namespace ringsplat
