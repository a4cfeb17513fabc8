#include "node/counting_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ringsplat/base/error.hpp"
#include "ringsplat/net/message.hpp"

namespace ringsplat {
namespace {

using Count = std::uint64_t;

class CountingEncoder final : public Encoder {
 public:
  CountingEncoder(std::unique_ptr<Encoder> encoder, double voxel_weight)
      : encoder_(std::move(encoder)), weight_(voxel_weight) {}

  void begin(const SliceView& slice) override { encoder_->begin(slice); }
  bool work() override { return encoder_->work(); }
  void take_opaque_news(std::span<const std::byte>) override {}
  void time_stages(StageSeconds* stages) override { encoder_->time_stages(stages); }

  EncodedSlice finish() override {
    EncodedSlice slice = encoder_->finish();
    slice.visible_voxels = weighted(slice.visible_voxels);
    slice.voxels_outside = weighted(slice.voxels_outside);
    slice.voxels = weighted(slice.voxels);
    for (std::size_t r = 0; r < slice.payloads.size(); ++r) {
      Bytes& payload = slice.payloads[r];
      if (payload.empty()) continue;
      const Count splats = weighted(slice.splats[r]);
      payload = counted(std::max(sizeof(Count), std::size_t(weighted(Message::body_size(payload)))), splats);
      slice.splats[r] = static_cast<std::uint32_t>(splats);
    }
    return slice;
  }

 private:
  Count weighted(Count count) const { return static_cast<Count>(std::llround(weight_ * double(count))); }

  /// What follows the count is never written nor read, so that it takes no memory before it travels.
  static Bytes counted(std::size_t size, Count splats) {
    Bytes body = Message::body_buffer();
    body.reserve(body.size() + size);
    append(body, splats);
    body.resize(body.size() + size - sizeof(Count));
    return body;
  }

  std::unique_ptr<Encoder> encoder_;
  double weight_;
};

class CountingPainter final : public Painter {
 public:
  CountingPainter(int renderer, int renderers) : renderer_(renderer), renderers_(renderers) {}

  void begin_frame(const FrameSpec&, const FrameGeometry& geometry) override {
    geometry_ = geometry;
    counts_ = {};
  }
  void begin(int, std::span<const std::byte> body) override {
    std::size_t at = 0;
    if (!take(body, at, here_) || here_ > body.size())
      throw RunError(
          fmt::format("Renderer {} got a payload of {} bytes that is no count", renderer_, body.size()),
          "all ranks must run the same build with the same options");
  }
  bool work() override {
    counts_.drawn += here_;
    return true;
  }
  void opaque_news(int, Bytes&) override {}
  PaintCounts counts() const override { return counts_; }
  double composite_seconds() const override { return 0; }

  void finish(const std::function<void(int, Bytes)>& deliver) override {
    for (const int region : geometry_.regions.owned(renderer_, geometry_.owners(renderers_))) {
      const PixelRect rect = geometry_.regions.rect(region);
      const auto pixels = std::size_t(rect.width()) * std::size_t(rect.height());
      Bytes body = Message::body_buffer();
      body.insert(body.end(), 4 * sizeof(float) * pixels, std::byte{0});
      deliver(region, std::move(body));
    }
  }

 private:
  int renderer_, renderers_;
  FrameGeometry geometry_;
  Count here_ = 0;
  PaintCounts counts_;
};

}  // namespace

std::unique_ptr<Encoder> make_counting_encoder(std::unique_ptr<Encoder> encoder, double voxel_weight) {
  return std::make_unique<CountingEncoder>(std::move(encoder), voxel_weight);
}

std::unique_ptr<Painter> make_counting_painter(int renderer, int renderers) {
  return std::make_unique<CountingPainter>(renderer, renderers);
}

}  // namespace ringsplat
