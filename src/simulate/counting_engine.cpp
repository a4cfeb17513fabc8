#include "simulate/counting_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/byte_stream.hpp"
#include "net/message.hpp"
#include "protocol/engine_decorator.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Content of a payload; must fit into counted_bytes.
struct Said {
  // Together eight bytes, so that a payload of few splats is not made longer.
  std::uint64_t items : 40 = 0;
  std::uint64_t slices : 24 = 0;
  std::uint64_t tiles = 0;  ///< bit mask of its Renderer's tiles with items
  PaintWork work = {};
};
static_assert(sizeof(Header) + sizeof(Said) <= counted_bytes);

/// Each tile's bit: its place among its Renderer's tiles. From the 64th on they share the last bit.
std::vector<std::uint64_t> tile_bits(const FramePlan& plan) {
  constexpr std::size_t last = 63;
  std::vector<std::uint64_t> bits(plan.tiles.size());
  std::map<int, std::size_t> owned;
  for (std::size_t tile = 0; tile < bits.size(); ++tile)
    if (const int renderer = plan.tiles[tile].renderer; renderer != FramePlan::nobody)
      bits[tile] = std::uint64_t{1} << std::min(owned[renderer]++, last);
  return bits;
}

class CountingEncoder final : public EncoderDecorator {
 public:
  CountingEncoder(std::unique_ptr<Encoder> inner, const FramePlan& plan, double voxel_weight)
      : EncoderDecorator(std::move(inner)), bits_(tile_bits(plan)), weight_(voxel_weight) {}

  void take_news(std::span<const std::byte>) override {}

  EncodedStep finish() override {
    EncodedStep step = inner_->finish();
    // Encoders of blocks weigh them themselves: so many more are so much smaller.
    const bool blocks = step.counts.blocks > 0;
    step.counts = {weighted(step.counts.voxels), weighted(step.counts.visible), weighted(step.counts.outside),
                   step.counts.blocks};
    for (EncodedPart& part : step.parts) {
      if (part.payload.empty()) continue;
      Said said;
      said.items = (blocks ? part.items : weighted(part.items)) & ((std::uint64_t{1} << 40) - 1);
      said.slices = part.slices & ((1U << 24) - 1);
      said.work = part.work;
      const std::size_t bytes = Message::body_size(part.payload);
      for (const int tile : part.tiles) said.tiles |= bits_[std::size_t(tile)];
      part.payload = counted(std::max(sizeof said, blocks ? bytes : std::size_t(weighted(bytes))), said);
      part.items = static_cast<std::uint32_t>(said.items);
      part.counted = true;
    }
    return step;
  }

 private:
  std::uint64_t weighted(std::uint64_t count) const {
    return static_cast<std::uint64_t>(std::llround(weight_ * double(count)));
  }

  /// The rest is never written or read, so it takes no memory until it is sent.
  static Bytes counted(std::size_t size, const Said& said) {
    Bytes body = Message::body_buffer();
    body.reserve(body.size() + size);
    append(body, said);
    body.resize(body.size() + size - sizeof said);
    return body;
  }

  std::vector<std::uint64_t> bits_;  ///< by tile
  double weight_;
};

class CountingPainter final : public Painter {
 public:
  CountingPainter(int renderer, FramePlan plan)
      : renderer_(renderer), plan_(std::move(plan)), bits_(tile_bits(plan_)) {}

  void begin(const PayloadToDraw& payload) override {
    std::size_t at = 0;
    if (!take(payload.body, at, here_) || here_.items > payload.body.size())
      throw RunError(fmt::format("Renderer {} got a payload of {} bytes that is no count", renderer_,
                                 payload.body.size()),
                     "all ranks must run the same build with the same options");
    reached_ |= here_.tiles;
  }
  bool work() override {
    counts_.drawn += here_.items;
    counts_.work.blocks += here_.work.blocks;
    counts_.work.samples += here_.work.samples;
    counts_.slices += here_.slices;
    return true;
  }
  void news(int, Bytes&) override {}
  ItemCounts counts() const override { return counts_; }

  void finish(const std::function<void(int, Bytes)>& deliver) override {
    for (std::size_t tile = 0; tile < bits_.size(); ++tile) {
      if (plan_.tiles[tile].renderer != renderer_ || (reached_ & bits_[tile]) == 0) continue;
      Bytes body = Message::body_buffer();
      body.insert(body.end(), plan_.tiles[tile].bytes, std::byte{0});
      deliver(int(tile), std::move(body));
    }
  }

 private:
  int renderer_;
  FramePlan plan_;
  std::vector<std::uint64_t> bits_;  ///< by tile
  Said here_;                        ///< the current payload's
  std::uint64_t reached_ = 0;
  ItemCounts counts_;
};

class CountingEngine final : public EngineDecorator {
 public:
  CountingEngine(std::unique_ptr<Engine> inner, double voxel_weight)
      : EngineDecorator(std::move(inner)), voxel_weight_(voxel_weight) {}

  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    return std::make_unique<CountingEncoder>(inner_->encoder(gp, a), inner_->plan(a), voxel_weight_);
  }

 private:
  std::unique_ptr<Painter> make_painter(int renderer, const Announcement& a) override {
    return std::make_unique<CountingPainter>(renderer, inner_->plan(a));
  }

  double voxel_weight_;
};

}  // namespace

std::unique_ptr<Engine> make_counting_engine(std::unique_ptr<Engine> inner, double voxel_weight) {
  return std::make_unique<CountingEngine>(std::move(inner), voxel_weight);
}

}  // namespace ringsplat
