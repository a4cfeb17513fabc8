#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "base/byte_stream.hpp"
#include "net/message.hpp"
#include "raster/slice_buffer.hpp"
#include "screen/regions.hpp"
#include "simulate/meter.hpp"
#include "splat/splat.hpp"
#include "splat/voxel_run.hpp"
#include "view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// Pixels that a lattice of `weight` voxels within a voxel's cell reaches beyond the voxel itself.
KernelReach beyond_voxel_of(const FrameGeometry& g, double weight) {
  if (weight <= 1) return {0, 0};
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec2 cell = glm::abs(glm::dvec2(g.view.linear[u])) + glm::abs(glm::dvec2(g.view.linear[v])),
                   beyond = 0.5 * (1 - 1 / std::sqrt(weight)) * cell;
  return {std::llround(beyond.x), std::llround(beyond.y)};
}

/// The pixels of a slice that a Renderer composites in a region: in each row the run from the first to the
/// last pixel block that a kernel may reach (as SplatSum does).
class PixelRuns {
 public:
  explicit PixelRuns(const PixelRect& rect) : rect_(rect) {}

  /// Adds the window of a kernel, of which only what lies in the region counts.
  void include(const PixelWindow& window) {
    const auto inside = [](std::int64_t pixel, int first, int pixels) {
      return int(std::clamp<std::int64_t>(pixel - first, 0, pixels));
    };
    const int x0 = inside(window.x0, rect_.x0, rect_.width()),
              x1 = inside(window.x1 + 1, rect_.x0, rect_.width()),
              y0 = inside(window.y0, rect_.y0, rect_.height()),
              y1 = inside(window.y1 + 1, rect_.y0, rect_.height());
    if (x0 >= x1) return;
    rows_.resize(std::size_t(rect_.height()));
    for (int y = y0; y < y1; ++y) rows_[std::size_t(y)].include(x0, x1);
  }
  /// Their pixels; forgets them.
  std::uint64_t take() {
    std::uint64_t pixels = 0;
    for (const PixelRun& run : rows_)
      if (!run.empty())
        pixels += std::uint64_t(in_whole_blocks(run.end) - run.first / block_pixels * block_pixels);
    rows_.clear();
    return pixels;
  }

 private:
  PixelRect rect_;
  std::vector<PixelRun> rows_;  ///< none where nothing was added
};

class SplatMeter {
 public:
  SplatMeter(std::shared_ptr<const SplatFrame> frame, double voxel_weight)
      : frame_(std::move(frame)),
        reach_(kernel_reach(frame_->footprint)),
        beyond_(beyond_voxel_of(geometry(), voxel_weight)),
        dda_(geometry().view, geometry().traversal.axis,
             geometry().grid.slice_width(geometry().traversal.axis)) {
    const Regions& regions = geometry().regions;
    for (int region = 0; region < regions.count(); ++region) pixels_.emplace_back(regions.rect(region));
  }

  std::vector<PaintWork> operator()(int step, const std::vector<EncodedPart>& parts) {
    std::vector<PaintWork> work(parts.size());
    slice_ = geometry().slice_at(step);
    for (std::size_t r = 0; r < parts.size(); ++r) {
      if (parts[r].payload.empty()) continue;
      const auto body = std::span<const std::byte>(parts[r].payload).subspan(sizeof(Header));
      include_runs(body);
      for (const int region : parts[r].tiles) work[r].samples += pixels_[std::size_t(region)].take();
    }
    return work;
  }

 private:
  const FrameGeometry& geometry() const { return frame_->geometry; }

  void include(int region, const Anchored& at) {
    const PixelWindow w = pixel_window(at, reach_);
    pixels_[std::size_t(region)].include(
        {w.x0 - beyond_.x, w.y0 - beyond_.y, w.x1 + beyond_.x, w.y1 + beyond_.y});
  }

  void include_runs(std::span<const std::byte> body) {
    BlockGroup group;
    for (std::size_t at = 0; take(body, at, group); at += group.voxels * sizeof(PackedVoxel))
      for (std::uint32_t k = 0; k < group.blocks; ++k) {
        VoxelRun block;
        if (!take(body, at, block)) return;
        dda_.begin_row(slice_, int(block.row));
        for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1) {
          const glm::dvec3 position = dda_.position(block.first + std::uint32_t(std::countr_zero(mask)));
          include(group.region, anchor(position.x, position.y));
        }
      }
  }

  std::shared_ptr<const SplatFrame> frame_;
  KernelReach reach_, beyond_;
  SliceDda dda_;
  std::vector<PixelRuns> pixels_;  ///< by region
  int slice_ = 0;
};

}  // namespace

Meter make_splat_meter(std::shared_ptr<const SplatFrame> frame, double voxel_weight) {
  return SplatMeter(std::move(frame), voxel_weight);
}

}  // namespace ringsplat
