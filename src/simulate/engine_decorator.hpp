#pragma once
#include <memory>
#include <utility>

#include "protocol/engine.hpp"

namespace ringsplat {

/// Forwards everything to another encoder; derived classes override what they change.
class EncoderDecorator : public Encoder {
 public:
  explicit EncoderDecorator(std::unique_ptr<Encoder> inner) : inner_(std::move(inner)) {}
  std::vector<int> shown() override { return inner_->shown(); }
  EncodeCounts left_out(std::size_t steps) const override { return inner_->left_out(steps); }
  bool prepare() override { return inner_->prepare(); }
  void begin(int step) override { inner_->begin(step); }
  bool work() override { return inner_->work(); }
  EncodedStep finish() override { return inner_->finish(); }
  void take_news(std::span<const std::byte> news) override { inner_->take_news(news); }
  StageSeconds stages() const override { return inner_->stages(); }
  std::uint64_t slice_memory() const override { return inner_->slice_memory(); }

 protected:
  std::unique_ptr<Encoder> inner_;
};

}  // namespace ringsplat
