#include "node/counting_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "node/payload_reader.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/net/message.hpp"

namespace ringsplat {
namespace {

/// All that a payload says: of more, counted_bytes has no room.
struct Said {
  std::uint64_t splats = 0;
  std::uint64_t regions = 0;  ///< of its Renderer's that it has splats of, as bits
};
static_assert(sizeof(Header) + sizeof(Said) <= counted_bytes);

/// Of a Renderer's regions; the 64th and all further ones share one.
std::uint64_t bit_of_region(std::size_t index) {
  constexpr std::size_t last = 63;
  return std::uint64_t{1} << std::min(index, last);
}

class CountingEncoder final : public Encoder {
 public:
  CountingEncoder(std::unique_ptr<Encoder> encoder, const FrameSpec& spec, const FrameGeometry& geometry,
                  int renderers, double voxel_weight)
      : encoder_(std::move(encoder)),
        reader_(spec.payload == PayloadForm::words ? make_word_reader() : make_run_reader(spec, geometry)),
        bits_(std::size_t(geometry.regions.count())),
        weight_(voxel_weight) {
    const RegionOwners owners = geometry.owners(renderers);
    std::vector<std::size_t> owned(std::size_t(renderers), 0);
    for (std::size_t region = 0; region < bits_.size(); ++region) {
      const int owner = owners.of(int(region));
      if (owner != RegionOwners::nobody) bits_[region] = bit_of_region(owned[std::size_t(owner)]++);
    }
  }

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
      const Said said{weighted(slice.splats[r]), regions_of(payload)};
      payload = counted(std::max(sizeof said, std::size_t(weighted(Message::body_size(payload)))), said);
      slice.splats[r] = static_cast<std::uint32_t>(said.splats);
    }
    return slice;
  }

 private:
  std::uint64_t weighted(std::uint64_t count) const {
    return static_cast<std::uint64_t>(std::llround(weight_ * double(count)));
  }

  std::uint64_t regions_of(const Bytes& payload) const {
    std::uint64_t regions = 0;
    const auto body = std::span<const std::byte>(payload).last(Message::body_size(payload));
    for (const PayloadPart& part : reader_->parts(body, [](int) { return true; }))
      regions |= bits_[std::size_t(part.region)];
    return regions;
  }

  /// The rest is never written nor read, so that it takes no memory before it travels.
  static Bytes counted(std::size_t size, const Said& said) {
    Bytes body = Message::body_buffer();
    body.reserve(body.size() + size);
    append(body, said);
    body.resize(body.size() + size - sizeof said);
    return body;
  }

  std::unique_ptr<Encoder> encoder_;
  std::unique_ptr<PayloadReader> reader_;
  std::vector<std::uint64_t> bits_;  ///< by region
  double weight_;
};

class CountingPainter final : public Painter {
 public:
  CountingPainter(int renderer, int renderers) : renderer_(renderer), renderers_(renderers) {}

  void begin_frame(const FrameSpec&, const FrameGeometry& geometry) override {
    regions_ = geometry.regions;
    owned_ = regions_.owned(renderer_, geometry.owners(renderers_));
    here_ = {};
    reached_ = 0;
    counts_ = {};
  }
  void begin(int, std::span<const std::byte> body) override {
    std::size_t at = 0;
    if (!take(body, at, here_) || here_.splats > body.size())
      throw RunError(
          fmt::format("Renderer {} got a payload of {} bytes that is no count", renderer_, body.size()),
          "all ranks must run the same build with the same options");
    reached_ |= here_.regions;
  }
  bool work() override {
    counts_.drawn += here_.splats;
    return true;
  }
  void opaque_news(int, Bytes&) override {}
  PaintCounts counts() const override { return counts_; }
  double composite_seconds() const override { return 0; }

  void finish(const std::function<void(int, Bytes)>& deliver) override {
    for (std::size_t k = 0; k < owned_.size(); ++k) {
      if ((reached_ & bit_of_region(k)) == 0) continue;
      const PixelRect rect = regions_.rect(owned_[k]);
      const auto pixels = std::size_t(rect.width()) * std::size_t(rect.height());
      Bytes body = Message::body_buffer();
      body.insert(body.end(), 4 * sizeof(float) * pixels, std::byte{0});
      deliver(owned_[k], std::move(body));
    }
  }

 private:
  int renderer_, renderers_;
  Regions regions_;
  std::vector<int> owned_;  ///< regions, ascending
  Said here_;               ///< by the payload
  std::uint64_t reached_ = 0;
  PaintCounts counts_;
};

}  // namespace

std::unique_ptr<Encoder> make_counting_encoder(std::unique_ptr<Encoder> encoder, const FrameSpec& spec,
                                               const FrameGeometry& geometry, int renderers,
                                               double voxel_weight) {
  return std::make_unique<CountingEncoder>(std::move(encoder), spec, geometry, renderers, voxel_weight);
}

std::unique_ptr<Painter> make_counting_painter(int renderer, int renderers) {
  return std::make_unique<CountingPainter>(renderer, renderers);
}

}  // namespace ringsplat
