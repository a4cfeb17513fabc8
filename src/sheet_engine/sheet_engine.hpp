#pragma once
#include <memory>

#include "base/thread_team.hpp"
#include "engine_parts/frame_engine.hpp"
#include "frame/engine_setup.hpp"
#include "sheet_engine/kept_blocks.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/slice_blocks.hpp"

namespace ringsplat {

/// Slices that a Renderer keeps at most before it has painted them.
inline constexpr int most_slices_kept = 36;

/// A GP's encoder for one frame. `store` and `blocks` must outlive it; `blocks` is kept from frame to frame,
/// one for each level of the store. `kept` outlives it, too, and is told of all frames in their order; null:
/// Renderers keep nothing. EngineSetup explains `skip_empty`. Throws RunError when the slices that the frame
/// traverses were not loaded.
std::unique_ptr<Encoder> make_sheet_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                            const SliceStore& store, SliceBlocks& blocks, bool skip_empty,
                                            KeptBlocks* kept = nullptr);

/// Encodes frames of several volumes together, to payloads that are joined (protocol/joined_step.hpp) by the
/// volumes' places among them.
std::unique_ptr<Encoder> make_channel_encoder(std::vector<std::unique_ptr<Encoder>> volumes);

/// A Renderer's painter. `threads` must outlive it; the image has the same bits with any number of them.
std::unique_ptr<FramePainter<SheetFrame>> make_sheet_painter(int renderer, ThreadTeam& threads);

/// The engine of sheets for one rank.
class SheetEngine : public FrameEngine<SheetFrame, SliceBlocks> {
 public:
  explicit SheetEngine(const EngineSetup& setup)
      : FrameEngine(setup),
        threads_(setup.threads),
        kept_(1 + setup.others.size(),
              KeptBlocks(setup.slices->gp(), setup.gps, setup.renderers, setup.kept_bytes)) {}

 protected:
  std::shared_ptr<const SheetFrame> make_frame(const std::vector<FrameOfVolume>& frames) override {
    const auto& [volume, spec] = frames.front();
    return with_others(
        make_sheet_frame(spec, setup_.grid, setup_.dealing(), setup_.renderers, &dealers_[volume]), frames);
  }
  std::unique_ptr<Encoder> encoder_of(std::shared_ptr<const SheetFrame> frame) override {
    if (frame->others.empty()) return FrameEngine::encoder_of(std::move(frame));
    std::vector<std::unique_ptr<Encoder>> encoders;
    for (auto& one : channels_of(std::move(frame)))
      encoders.push_back(FrameEngine::encoder_of(std::move(one)));
    return make_channel_encoder(std::move(encoders));
  }
  std::unique_ptr<Encoder> make_encoder(std::shared_ptr<const SheetFrame> frame,
                                        SliceBlocks& blocks) override {
    const SliceStore& slices = slices_of(*frame);
    KeptBlocks& kept = kept_[frame->volume];
    return make_sheet_encoder(std::move(frame), setup_.renderers, slices, blocks, setup_.skip_empty, &kept);
  }
  std::unique_ptr<FramePainter<SheetFrame>> make_painter(int renderer) override {
    return make_sheet_painter(renderer, threads_);
  }

 private:
  ThreadTeam threads_;
  std::vector<KeptBlocks> kept_;  ///< by volume
};

}  // namespace ringsplat
