#include "simulate/simulated_engines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/byte_stream.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "protocol/bundle_engine.hpp"
#include "protocol/engine_decorator.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/meter.hpp"

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

/// What the measured payloads of a step's slices say together.
struct Measured {
  std::size_t bytes = 0;
  int slices = 0;
  PaintWork work;

  void add(const MeasuredPayload& slice, bool joined) {
    bytes = joined ? joined_with(bytes, slice.bytes) : slice.bytes;
    ++slices;
    work.blocks += slice.work.blocks;
    work.samples += slice.work.samples;
  }
};

Measured read_measured(std::span<const std::byte> body, bool joined) {
  Measured all;
  for (std::size_t at = 0; at < body.size();) {
    BundlePart part;
    MeasuredPayload slice;
    if ((joined && !take_part(body, at, part)) || !take(body, at, slice)) break;
    all.add(slice, joined);
  }
  return all;
}

/// How many times as many voxels and items there are as an encoder says. Sheets' blocks are weighed where
/// they are encoded: so many more are so much smaller.
struct Weights {
  double voxels, items;
};

class CountingEncoder final : public EncoderDecorator {
 public:
  CountingEncoder(std::unique_ptr<Encoder> inner, const FramePlan& plan, Weights weights)
      : EncoderDecorator(std::move(inner)),
        bits_(tile_bits(plan)),
        joined_(!plan.slices_of_steps.empty()),
        weights_(weights) {}

  void take_news(std::span<const std::byte>) override {}

  EncodedStep finish() override {
    EncodedStep step = inner_->finish();
    step.counts = {times(weights_.voxels, step.counts.voxels), times(weights_.voxels, step.counts.visible),
                   times(weights_.voxels, step.counts.outside), step.counts.blocks};
    for (EncodedPart& part : step.parts)
      if (!part.payload.empty()) count(part);
    return step;
  }

 private:
  static std::uint64_t times(double weight, std::uint64_t count) {
    return static_cast<std::uint64_t>(std::llround(weight * double(count)));
  }

  void count(EncodedPart& part) const {
    const Measured measured =
        read_measured(std::span<const std::byte>(part.payload).subspan(sizeof(Header)), joined_);
    Said said;
    said.items = times(weights_.items, part.items) & ((std::uint64_t{1} << 40) - 1);
    said.slices = std::uint64_t(measured.slices) & ((1U << 24) - 1);
    said.work = measured.work;
    for (const int tile : part.tiles) said.tiles |= bits_[std::size_t(tile)];
    part.payload = counted(std::max(sizeof said, std::size_t(times(weights_.items, measured.bytes))), said);
    part.items = static_cast<std::uint32_t>(said.items);
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
  bool joined_;                      ///< steps are bundles
  Weights weights_;
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
    counts_.blocks += here_.work.blocks;
    counts_.samples += here_.work.samples;
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
    const bool sheets = method_of(a.body) == Sheets::name;
    return std::make_unique<CountingEncoder>(inner_->encoder(gp, a), inner_->plan(a),
                                             Weights{voxel_weight_, sheets ? 1 : voxel_weight_});
  }

 private:
  std::unique_ptr<Painter> make_painter(int renderer, const Announcement& a) override {
    return std::make_unique<CountingPainter>(renderer, inner_->plan(a));
  }

  double voxel_weight_;
};

}  // namespace

std::unique_ptr<Engine> make_counting_engine(const EngineSetup& setup, double voxel_weight) {
  auto engine = make_measured_engines(setup, voxel_weight);
  if (setup.bundle > 1) engine = make_bundle_engine(std::move(engine), setup.bundle);
  return std::make_unique<CountingEngine>(std::move(engine), voxel_weight);
}

int slices_counted(std::span<const std::byte> payload) {
  Said said;
  std::size_t at = 0;
  return take(payload, at, said) ? int(said.slices) : 0;
}

}  // namespace ringsplat
