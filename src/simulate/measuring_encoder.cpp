#include "base/byte_stream.hpp"
#include "net/message.hpp"
#include "protocol/engine_decorator.hpp"
#include "simulate/meter.hpp"

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

}  // namespace ringsplat
