#pragma once
#include <fmt/format.h>

#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "node/payload_reader.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {

/// Takes a payload of runs apart and goes through a part of it, run by run.
template <class Voxel>
class RunCursor {
 public:
  /// `width`, `height`: of the slice, in voxels.
  RunCursor(int width, int height) : width_(std::uint32_t(width)), height_(std::uint32_t(height)) {}

  /// Throws RunError when `body` is no payload of runs in such a slice for regions, ascending, that `owned`
  /// is true of.
  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const {
    std::vector<PayloadPart> parts;
    for (std::size_t at = 0, begin = 0; at < body.size(); begin = at) {
      RunGroup group;
      const int last = parts.empty() ? -1 : parts.back().region;
      if (!take(body, at, group) || group.region <= last || !owned(group.region) ||
          !check_runs(group, body, at))
        throw RunError(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at),
                       "all ranks must run the same build");
      parts.push_back({group.region, body.subspan(begin, at - begin)});
    }
    return parts;
  }

  void begin(const PayloadPart& part) {
    body_ = part.bytes;
    at_ = 0;
    run_ = {};
    RunGroup group;
    runs_left_ = take(body_, at_, group) ? group.runs : 0;
    voxel_at_ = at_ + runs_left_ * sizeof(VoxelRun);
  }

  /// Goes to a run with voxels left; false at the part's end.
  bool find() {
    if (run_.count > 0) return true;
    if (runs_left_ == 0) return false;
    --runs_left_;
    return take(body_, at_, run_);
  }
  /// What is left of the run.
  const VoxelRun& run() const { return run_; }
  Voxel voxel(std::uint32_t k) const {
    Voxel voxel;
    std::memcpy(&voxel, body_.data() + voxel_at_ + k * sizeof voxel, sizeof voxel);
    return voxel;
  }
  /// The run's voxels that are left, where they are in the payload.
  std::span<const Voxel> voxels() const {
    return {reinterpret_cast<const Voxel*>(body_.data() + voxel_at_), run_.count};
  }
  void skip(std::uint32_t voxels) {
    voxel_at_ += voxels * sizeof(Voxel);
    run_.first += voxels;
    run_.count -= voxels;
  }

 private:
  /// Moves `at` behind the group; false when it is not whole or a run leaves the slice.
  bool check_runs(const RunGroup& group, std::span<const std::byte> body, std::size_t& at) const {
    if (group.runs == 0 || (body.size() - at) / sizeof(VoxelRun) < group.runs) return false;
    std::uint64_t voxels = 0;
    for (std::uint32_t k = 0; k < group.runs; ++k) {
      VoxelRun run;
      if (!take(body, at, run) || run.row >= height_ || run.first >= width_ || run.count == 0 ||
          run.count > width_ - run.first)
        return false;
      voxels += run.count;
    }
    if (voxels != group.voxels || (body.size() - at) / sizeof(Voxel) < group.voxels) return false;
    at += group.voxels * sizeof(Voxel);
    return true;
  }

  std::uint32_t width_, height_;
  std::span<const std::byte> body_;    ///< of the part
  std::size_t at_ = 0, voxel_at_ = 0;  ///< bytes into it: the next run, the next voxel
  std::uint32_t runs_left_ = 0;
  VoxelRun run_{};
};

}  // namespace ringsplat
