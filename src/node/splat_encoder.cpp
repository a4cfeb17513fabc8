#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/net/message.hpp"
#include "ringsplat/node/engine.hpp"
#include "ringsplat/splat/encode.hpp"
#include "ringsplat/view/slice_dda.hpp"

namespace ringsplat {
namespace {

/// The splats of one slice that go to one region, as they travel: groups of a head and its splats.
struct RegionStream {
  Bytes bytes;
  std::size_t size = 0;   ///< bytes in use; `bytes` only grows
  std::size_t group = 0;  ///< where the open group's head is
  SplatGroup head{};
  std::uint32_t splats = 0;
  std::array<std::uint64_t, 4> passes{};  ///< which passes have a splat, a bit each

  bool empty() const { return splats == 0; }
  std::byte* grow(std::size_t count) {
    if (bytes.size() < size + count) bytes.resize(std::max(2 * bytes.size(), size + std::max<std::size_t>(count, 4096)));
    return bytes.data() + std::exchange(size, size + count);
  }
  void reset() {
    size = 0;
    splats = 0;
    passes = {};
  }
};

/// The paper's engine on a GP: classify, shade, transform by DDA, compute the quadratic's coefficients, sort by region.
class SplatEncoder final : public Encoder {
 public:
  SplatEncoder(const FrameSpec& spec, const FrameGeometry& geometry, const Grid& grid, int renderers)
      : geometry_(geometry),
        renderers_(renderers),
        classifier_(spec.transfer_function, grid.type, spec.opacity_correction ? geometry.traversal.slice_distance : 1.0),
        dda_(geometry.view, geometry.traversal.axis, grid.slice_width(geometry.traversal.axis)),
        reach_(kernel_reach(geometry.footprint)),
        stride_(pass_stride(spec.kernel_radius)),
        streams_(std::size_t(geometry.regions.count())) {
    if (spec.shading == Shading::phong) {
      const auto& view = geometry.view;
      phong_.emplace(spec.material, view.right * spec.light.x + view.up * spec.light.y + view.to_viewer * spec.light.z, view.to_viewer);
    }
    const auto width = std::size_t(grid.slice_width(geometry.traversal.axis));
    where_.resize(width);
    samples_.resize(width);
  }

  void begin(const SliceView& slice) override {
    slice_ = slice;
    row_ = 0;
    visible_ = 0;
  }

  bool work() override {
    // Bounded by what costs: visible voxels, or many transparent ones.
    constexpr int visible_at_most = 4096, voxels_at_most = 65536;
    int visible = 0, voxels = 0;
    while (row_ < slice_.height && visible < visible_at_most && voxels < voxels_at_most) {
      visible += encode_row(row_++);
      voxels += slice_.width;
    }
    visible_ += std::uint64_t(visible);
    return row_ == slice_.height;
  }

  EncodedSlice finish() override {
    EncodedSlice encoded;
    encoded.payloads.resize(std::size_t(renderers_));
    encoded.splats.resize(std::size_t(renderers_));
    encoded.visible_voxels = visible_;
    std::sort(used_.begin(), used_.end());
    std::vector<std::size_t> sizes(std::size_t(renderers_), 0);
    for (const int region : used_) sizes[std::size_t(Regions::owner(region, renderers_))] += streams_[std::size_t(region)].size;
    for (const int region : used_) {
      RegionStream& stream = streams_[std::size_t(region)];
      close_group(stream);
      const auto owner = std::size_t(Regions::owner(region, renderers_));
      Bytes& payload = encoded.payloads[owner];
      if (payload.empty()) {
        payload = Message::body_buffer();
        payload.reserve(payload.size() + sizes[owner]);
      }
      payload.insert(payload.end(), stream.bytes.begin(), stream.bytes.begin() + static_cast<std::ptrdiff_t>(stream.size));
      encoded.splats[owner] += stream.splats;
      for (const auto bits : stream.passes) encoded.passes += std::uint64_t(std::popcount(bits));
      stream.reset();
    }
    used_.clear();
    return encoded;
  }

 private:
  int encode_row(int row) {
    const std::size_t first = std::size_t(row) * std::size_t(slice_.width);
    const int visible = classifier_.classify_row(slice_.values + first * size_of(slice_.type), slice_.width, where_.data(), samples_.data());
    if (visible == 0) return 0;
    if (phong_ && slice_.normals != nullptr) phong_->shade_row(slice_.normals + first, where_.data(), samples_.data(), visible);
    dda_.begin_row(slice_.index, row);
    for (int k = 0; k < visible; ++k) place(where_[std::size_t(k)], row, samples_[std::size_t(k)]);
    return visible;
  }

  /// Makes the voxel's splat and puts it into every region its kernel reaches (one, two or four of them, more when
  /// kernels are larger than regions).
  void place(std::uint32_t column, int row, const ClassifiedSample& sample) {
    const glm::dvec3 position = dda_.position(column);
    const Anchored at = anchor(position.x, position.y);
    const PixelWindow window = pixel_window(at, reach_);
    const Splat splat = make_splat(geometry_.footprint, at.dx, at.dy, sample.r, sample.g, sample.b, sample.opacity);
    const int pass = static_cast<int>(column) % stride_ + stride_ * (row % stride_);
    if (window.x0 >= inside_.x0 && window.x1 < inside_.x1 && window.y0 >= inside_.y0 && window.y1 < inside_.y1) {
      append(inside_region_, at, splat, pass);
      return;
    }
    const PixelRect touched = geometry_.regions.touched(window.x0, window.y0, window.x1, window.y1);
    for (int y = touched.y0; y < touched.y1; ++y)
      for (int x = touched.x0; x < touched.x1; ++x) {
        inside_region_ = y * geometry_.regions.columns() + x;
        append(inside_region_, at, splat, pass);
      }
    if (!touched.empty()) inside_ = geometry_.regions.rect(inside_region_);
  }

  void append(int region, const Anchored& at, Splat splat, int pass) {
    RegionStream& stream = streams_[std::size_t(region)];
    if (stream.empty()) used_.push_back(region);
    const std::int64_t dx = at.anchor_x - stream.head.base_x, dy = at.anchor_y - stream.head.base_y;
    if (stream.empty() || dx < 0 || dx > 255 || dy < 0 || dy > 255) {
      open_group(region, at);
      append_to_group(stream, static_cast<std::uint8_t>(at.anchor_x - stream.head.base_x),
                      static_cast<std::uint8_t>(at.anchor_y - stream.head.base_y), splat);
    } else {
      append_to_group(stream, static_cast<std::uint8_t>(dx), static_cast<std::uint8_t>(dy), splat);
    }
    stream.passes[std::size_t(pass) / 64] |= std::uint64_t{1} << (pass % 64);
  }

  static void append_to_group(RegionStream& stream, std::uint8_t dx, std::uint8_t dy, Splat& splat) {
    splat.anchor_x = dx;
    splat.anchor_y = dy;
    std::memcpy(stream.grow(sizeof(Splat)), &splat, sizeof(Splat));
    ++stream.head.count;
    ++stream.splats;
  }

  /// A base before the region's corner by the kernel's reach holds all anchors of a region of up to 250 pixels in one group;
  /// further ones count from a lattice of 256 pixels that starts there.
  void open_group(int region, const Anchored& at) {
    RegionStream& stream = streams_[std::size_t(region)];
    if (!stream.empty()) close_group(stream);
    const PixelRect rect = geometry_.regions.rect(region);
    const auto base = [](std::int64_t anchor_pixel, std::int64_t corner) {
      return static_cast<std::int32_t>(corner + ((anchor_pixel - corner) & ~std::int64_t{255}));
    };
    stream.head = {region, base(at.anchor_x, rect.x0 - reach_.x - 1), base(at.anchor_y, rect.y0 - reach_.y - 1), 0};
    stream.group = stream.size;
    stream.grow(sizeof(SplatGroup));
  }

  static void close_group(RegionStream& stream) { std::memcpy(stream.bytes.data() + stream.group, &stream.head, sizeof(SplatGroup)); }

  FrameGeometry geometry_;
  int renderers_;
  Classifier classifier_;
  std::optional<PhongTable> phong_;
  SliceDda dda_;
  KernelReach reach_;
  int stride_;
  std::vector<RegionStream> streams_;  ///< by region
  std::vector<int> used_;              ///< regions with splats in this slice
  PixelRect inside_{};                 ///< the region of the last splat: most voxels stay in it
  int inside_region_ = 0;
  SliceView slice_;
  int row_ = 0;
  std::uint64_t visible_ = 0;
  std::vector<std::uint32_t> where_;
  std::vector<ClassifiedSample> samples_;
};

}  // namespace

std::unique_ptr<Encoder> make_encoder(const FrameSpec& spec, const FrameGeometry& geometry, const Grid& grid, int renderers) {
  return std::make_unique<SplatEncoder>(spec, geometry, grid, renderers);
}

}  // namespace ringsplat
