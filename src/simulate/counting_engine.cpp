#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/byte_stream.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "protocol/engine_decorator.hpp"
#include "protocol/joined_step.hpp"
#include "ringsplat/base/error.hpp"
#include "session/render_frames.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/meter.hpp"
#include "splat_engine/splat_engine.hpp"

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
  /// Weights: how many times as many voxels and items there are as `inner` says.
  CountingEncoder(std::unique_ptr<Encoder> inner, const FramePlan& plan, double voxel_weight,
                  double item_weight)
      : EncoderDecorator(std::move(inner)),
        bits_(tile_bits(plan)),
        joined_(!plan.slices_of_steps.empty()),
        voxel_weight_(voxel_weight),
        item_weight_(item_weight) {}

  void take_news(std::span<const std::byte>) override {}

  EncodedStep finish() override {
    EncodedStep step = inner_->finish();
    step.counts = {times(voxel_weight_, step.counts.voxels), times(voxel_weight_, step.counts.visible),
                   times(voxel_weight_, step.counts.outside), step.counts.blocks};
    for (EncodedPart& part : step.parts)
      if (!part.payload.empty()) count(part);
    return step;
  }

 private:
  static std::uint64_t times(double weight, std::uint64_t count) {
    return static_cast<std::uint64_t>(std::llround(weight * double(count)));
  }

  void count(EncodedPart& part) const {
    Said said;
    said.items = times(item_weight_, part.items) & ((std::uint64_t{1} << 40) - 1);
    // What the measured payloads of the step's slices say together.
    const auto body = std::span<const std::byte>(part.payload).subspan(sizeof(Header));
    std::size_t bytes = 0;
    for (std::size_t at = 0; at < body.size(); ++said.slices) {
      JoinedPart head;
      MeasuredPayload slice;
      if ((joined_ && !take_part(body, at, head)) || !take(body, at, slice)) break;
      bytes = joined_ ? joined_with(bytes, slice.bytes) : slice.bytes;
      said.work.blocks += slice.work.blocks;
      said.work.samples += slice.work.samples;
    }
    for (const int tile : part.tiles) said.tiles |= bits_[std::size_t(tile)];
    const auto size = std::max(sizeof said, std::size_t(times(item_weight_, bytes)));
    part.payload = Message::body_buffer();
    part.payload.reserve(part.payload.size() + size);
    append(part.payload, said);
    // The rest is never written or read, so it takes no memory until it is sent.
    part.payload.resize(part.payload.size() + size - sizeof said);
    part.items = static_cast<std::uint32_t>(said.items);
  }

  std::vector<std::uint64_t> bits_;  ///< by tile
  bool joined_;                      ///< steps are bundles
  double voxel_weight_, item_weight_;
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
    // Sheets' blocks are weighed where they are encoded: so many more are so much smaller.
    const bool sheets = std::holds_alternative<Sheets>(method_of(a.body));
    return std::make_unique<CountingEncoder>(inner_->encoder(gp, a), inner_->plan(a), voxel_weight_,
                                             sheets ? 1 : voxel_weight_);
  }
  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    return std::make_shared<CountingPainter>(renderer, inner_->plan(a));
  }

 private:
  double voxel_weight_;
};

class MeasuringEncoder final : public EncoderDecorator {
 public:
  MeasuringEncoder(std::unique_ptr<Encoder> inner, Meter meter)
      : EncoderDecorator(std::move(inner)), meter_(std::move(meter)) {}

  void begin(int step) override {
    step_ = step;
    inner_->begin(step);
  }
  EncodedStep finish() override {
    EncodedStep step = inner_->finish();
    const std::vector<PaintWork> work = meter_(step_, step.parts);
    for (std::size_t r = 0; r < step.parts.size(); ++r) {
      EncodedPart& part = step.parts[r];
      if (part.payload.empty()) continue;
      part.payload = measured_payload({Message::body_size(part.payload), work[r]});
      part.items -= std::exchange(part.kept, 0);
    }
    return step;
  }

 private:
  Meter meter_;
  int step_ = 0;
};

// Engines whose encoders make measured payloads (simulate/meter.hpp), which nobody can draw. Each voxel
// stands for `voxel_weight` of its slice: sheets have as many blocks as those would make; splats are as many
// as voxels, with kernels as large as those would have.

class MeasuredSplats final : public SplatEngine {
 public:
  MeasuredSplats(const EngineSetup& setup, double voxel_weight)
      : SplatEngine(setup), voxel_weight_(voxel_weight) {}

 private:
  std::shared_ptr<const SplatFrame> make_frame(const std::vector<FrameOfVolume>& frames) override {
    return make_weighed_frame(frames.front().spec, setup_.grid, setup_.dealing(), setup_.renderers,
                              voxel_weight_, &dealers_.front());
  }
  std::unique_ptr<Encoder> make_encoder(std::shared_ptr<const SplatFrame> frame, EmptySpace& space) override {
    return make_measuring_encoder(SplatEngine::make_encoder(frame, space),
                                  make_splat_meter(frame, voxel_weight_));
  }

  double voxel_weight_;
};

class MeasuredSheets final : public SheetEngine {
 public:
  MeasuredSheets(const EngineSetup& setup, double voxel_weight)
      : SheetEngine(setup), voxel_weight_(voxel_weight) {}

 private:
  std::unique_ptr<Encoder> make_encoder(std::shared_ptr<const SheetFrame> frame,
                                        SliceBlocks& blocks) override {
    if (voxel_weight_ > 1)
      return make_weighed_encoder(std::move(frame), setup_.renderers, *setup_.slices, voxel_weight_);
    return make_measuring_encoder(SheetEngine::make_encoder(frame, blocks), make_sheet_meter(frame));
  }

  double voxel_weight_;
};

}  // namespace

std::unique_ptr<Engine> make_counting_engine(EngineSetup setup, double voxel_weight) {
  setup.skip_empty = false;
  auto engine =
      make_engines(setup, {maker_of<MeasuredSplats>(voxel_weight), maker_of<MeasuredSheets>(voxel_weight)});
  return std::make_unique<CountingEngine>(std::move(engine), voxel_weight);
}

int slices_counted(std::span<const std::byte> payload) {
  Said said;
  std::size_t at = 0;
  return take(payload, at, said) ? int(said.slices) : 0;
}

Bytes measured_payload(const MeasuredPayload& payload) {
  Bytes body = Message::body_buffer();
  append(body, payload);
  return body;
}

std::unique_ptr<Encoder> make_measuring_encoder(std::unique_ptr<Encoder> inner, Meter meter) {
  return std::make_unique<MeasuringEncoder>(std::move(inner), std::move(meter));
}

std::shared_ptr<const SplatFrame> make_weighed_frame(const FrameSpec& spec, const Grid& grid,
                                                     SliceDealing dealing, int renderers, double voxel_weight,
                                                     RegionDealer* dealer) {
  FrameGeometry geometry = make_geometry(spec, grid);
  geometry.reach = narrowed(geometry.reach, voxel_weight);
  lay_regions(geometry, spec);
  auto frame = std::make_shared<SplatFrame>(spec, std::move(geometry), dealing, renderers, dealer);
  frame->footprint.half = narrowed(frame->footprint.half, voxel_weight);
  return frame;
}

}  // namespace ringsplat
