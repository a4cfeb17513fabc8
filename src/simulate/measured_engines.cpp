#include <type_traits>
#include <utility>

#include "base/byte_stream.hpp"
#include "classify/empty_space.hpp"
#include "engine_parts/frame_engine.hpp"
#include "engine_parts/frame_plan.hpp"
#include "frame/frame_geometry.hpp"
#include "net/message.hpp"
#include "protocol/engine_decorator.hpp"
#include "session/engines.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "simulate/meter.hpp"
#include "simulate/work_costs.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

class MeasuringEncoder final : public EncoderDecorator {
 public:
  MeasuringEncoder(std::unique_ptr<Encoder> inner, std::unique_ptr<Meter> meter)
      : EncoderDecorator(std::move(inner)), meter_(std::move(meter)) {}

  void begin(int step) override {
    step_ = step;
    inner_->begin(step);
  }
  EncodedStep finish() override {
    EncodedStep step = inner_->finish();
    const std::vector<PaintWork> work = meter_->work_of(step_, step.parts);
    for (std::size_t r = 0; r < step.parts.size(); ++r)
      if (Bytes& payload = step.parts[r].payload; !payload.empty())
        payload = measured_payload({Message::body_size(payload), work[r]});
    return step;
  }

 private:
  std::unique_ptr<Meter> meter_;
  int step_ = 0;
};

/// Of one method: how its frames and a GP's encoders are made.
template <class FrameType, class KeptType>
class MeasuredParts {
 public:
  using Frame = FrameType;
  using Kept = KeptType;
  explicit MeasuredParts(const EngineSetup& setup, double voxel_weight)
      : setup_(setup), dealer_(setup), threads_(setup.threads), voxel_weight_(voxel_weight) {}

  std::shared_ptr<const Frame> frame(const FrameSpec& spec) {
    if constexpr (std::is_same_v<Frame, SplatFrame>)
      return make_weighed_frame(spec, setup_.grid, setup_.dealing(), setup_.renderers, voxel_weight_,
                                &dealer_);
    else
      return make_sheet_frame(spec, setup_.grid, setup_.dealing(), setup_.renderers, &dealer_);
  }
  std::unique_ptr<Encoder> encoder(std::shared_ptr<const SplatFrame> frame, EmptySpace& space) {
    return make_measuring_encoder(
        make_splat_encoder(frame, setup_.renderers, *setup_.slices, space, threads_, false, setup_.timed),
        make_splat_meter(frame, voxel_weight_));
  }
  std::unique_ptr<Encoder> encoder(std::shared_ptr<const SheetFrame> frame, SliceBlocks& blocks) {
    if (voxel_weight_ > 1)
      return make_weighed_encoder(std::move(frame), setup_.renderers, *setup_.slices, voxel_weight_);
    return make_measuring_encoder(make_sheet_encoder(frame, setup_.renderers, *setup_.slices, blocks, false),
                                  make_sheet_meter(frame));
  }
  /// Nobody draws measured payloads.
  std::unique_ptr<FramePainter<Frame>> painter(int) { return nullptr; }

 private:
  EngineSetup setup_;
  RegionDealer dealer_;
  ThreadTeam threads_;
  double voxel_weight_;
};

template <class Frame, class Kept>
MethodEngine measured_engine(const char* method, double voxel_weight) {
  return {method, [voxel_weight](const EngineSetup& setup) -> std::unique_ptr<Engine> {
            return std::make_unique<FrameEngine<MeasuredParts<Frame, Kept>>>(setup, voxel_weight);
          }};
}

}  // namespace

Bytes measured_payload(const MeasuredPayload& payload) {
  Bytes body = Message::body_buffer();
  append(body, payload);
  return body;
}

std::unique_ptr<Encoder> make_measuring_encoder(std::unique_ptr<Encoder> inner,
                                                std::unique_ptr<Meter> meter) {
  return std::make_unique<MeasuringEncoder>(std::move(inner), std::move(meter));
}

std::unique_ptr<Engine> make_measured_engines(const EngineSetup& setup, double voxel_weight) {
  return make_engines(setup, {measured_engine<SplatFrame, EmptySpace>(Splats::name, voxel_weight),
                              measured_engine<SheetFrame, SliceBlocks>(Sheets::name, voxel_weight)});
}

std::shared_ptr<const SplatFrame> make_weighed_frame(const FrameSpec& spec, const Grid& grid,
                                                     SliceDealing dealing, int renderers, double voxel_weight,
                                                     RegionDealer* dealer) {
  if (!(voxel_weight > 1)) return make_splat_frame(spec, grid, dealing, renderers, dealer);
  FrameGeometry geometry = make_geometry(spec, grid);
  geometry.reach = narrowed(geometry.reach, voxel_weight);
  lay_regions(geometry, spec);
  auto frame = make_splat_frame(spec, std::move(geometry), dealing, renderers, dealer);
  frame->footprint.half = narrowed(frame->footprint.half, voxel_weight);
  return frame;
}

}  // namespace ringsplat
