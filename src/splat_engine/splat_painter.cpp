#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "engine_parts/frame_engine.hpp"
#include "splat_engine/payload_reader.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

/// The paper's engine on a Renderer: sums each slice's splats region by region and composites the slice
/// behind the image.
class SplatPainter final : public FramePainter<SplatFrame> {
 public:
  SplatPainter(int renderer, ThreadTeam& threads)
      : FramePainter(renderer, threads), lanes_(std::size_t(threads.size())) {}

  void begin_frame(std::shared_ptr<const SplatFrame> frame) override {
    for (Lane& lane : lanes_) {
      lane.reader.emplace(*frame);  // the one before refers to the last frame
      lane.drawing = false;
    }
    FramePainter::begin_frame(std::move(frame));
    composite_seconds_ = 0;
  }

  void begin(const PayloadToDraw& payload) override {
    const auto& [step, passes, body] = payload;
    read_payload(step, [&] {
      parts_ = lanes_.front().reader->parts(body, [this](int region) { return images_.owns(region); });
    });
    slice_ = geometry().slice_at(step);
    next_part_ = 0;
    // Waking a thread costs as much as some hundred splats.
    constexpr std::size_t bytes_worth_a_thread = 4096;
    lanes_in_use_ = int(std::clamp(std::min(parts_.size(), body.size() / bytes_worth_a_thread),
                                   std::size_t{1}, lanes_.size()));
    // Largest regions first, so that threads finish at about the same time; any order is correct.
    if (lanes_in_use_ > 1)
      std::sort(parts_.begin(), parts_.end(),
                [](const auto& one, const auto& other) { return one.voxels > other.voxels; });
  }

  bool work() override {
    double wall = 0;
    {
      const ScopedSeconds timed(lanes_in_use_ > 1 ? &wall : nullptr);
      threads_.run(lanes_in_use_, [this](int lane) { draw_some(lanes_[std::size_t(lane)]); });
    }
    bool complete = next_part_ >= parts_.size();
    double busy = 0, compositing = 0;
    for (int k = 0; k < lanes_in_use_; ++k) {
      Lane& lane = lanes_[std::size_t(k)];
      complete = complete && !lane.drawing;
      const ItemCounts counts = std::exchange(lane.counts, {});
      counts_.drawn += counts.drawn;
      counts_.clipped += counts.clipped;
      counts_.hidden += counts.hidden;
      counts_.samples += counts.samples;
      busy += std::exchange(lane.busy, 0);
      compositing += std::exchange(lane.compositing, 0);
    }
    // Of several threads the same part of the wall-clock time as of theirs, so that a node's seconds add up.
    if (lanes_in_use_ > 1) compositing = busy > 0 ? wall * std::min(compositing / busy, 1.0) : 0;
    composite_seconds_ += compositing;
    return complete;
  }

  double composite_seconds() const override { return composite_seconds_; }

 private:
  /// What a thread draws with.
  struct alignas(64) Lane {
    std::optional<PayloadReader> reader;
    bool drawing = false;  ///< its part is not complete yet
    ItemCounts counts;     ///< counts and seconds since work() last collected them
    double busy = 0, compositing = 0;
  };

  /// Draws parts. One lane draws a whole part, so its splats keep their order.
  void draw_some(Lane& lane) {
    // Small, because messages wait until work() returns, and threads wait for each other.
    const std::int64_t splats_at_most = lanes_in_use_ > 1 ? 4096 : 1024, chunk_splats = 512;
    const ScopedSeconds timed(lanes_in_use_ > 1 ? &lane.busy : nullptr);
    for (std::int64_t budget = splats_at_most; budget > 0;) {
      if (!lane.drawing && !take_part(lane)) return;
      if (!lane.reader->more()) {
        const ScopedSeconds composited(&lane.compositing);
        lane.counts.samples += lane.reader->composite();
        lane.drawing = false;
        continue;
      }
      const DrawCounts drawn = lane.reader->draw(std::uint32_t(std::min(budget, chunk_splats)));
      lane.counts.drawn += drawn.drawn;
      lane.counts.clipped += drawn.clipped;
      lane.counts.hidden += drawn.hidden;
      budget -= std::int64_t(drawn.drawn + drawn.clipped + drawn.hidden);
    }
  }

  bool take_part(Lane& lane) {
    const std::size_t k = next_part_++;
    if (k >= parts_.size()) return false;
    lane.reader->begin(slice_, parts_[k], images_.image(images_.slot_of(parts_[k].region)));
    lane.drawing = true;
    return true;
  }

  std::vector<Lane> lanes_;  ///< one for each thread
  int lanes_in_use_ = 1;     ///< lanes that this payload uses
  std::vector<PayloadPart> parts_;
  std::atomic<std::size_t> next_part_ = 0;
  int slice_ = 0;
  double composite_seconds_ = 0;
};

}  // namespace

std::unique_ptr<FramePainter<SplatFrame>> make_splat_painter(int renderer, ThreadTeam& threads) {
  return std::make_unique<SplatPainter>(renderer, threads);
}

}  // namespace ringsplat
