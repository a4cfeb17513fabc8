#pragma once
#include <memory>
#include <utility>

#include "protocol/engine.hpp"

/// Engines that change what another engine does. These forward what not every derived one changes.
namespace ringsplat {

class EncoderDecorator : public Encoder {
 public:
  explicit EncoderDecorator(std::unique_ptr<Encoder> inner) : inner_(std::move(inner)) {}
  std::vector<int> shown() override { return inner_->shown(); }
  std::uint64_t left_out(std::size_t steps) const override { return inner_->left_out(steps); }
  bool prepare() override { return inner_->prepare(); }
  void begin(int step) override { inner_->begin(step); }
  bool work() override { return inner_->work(); }
  void take_news(std::span<const std::byte> news) override { inner_->take_news(news); }
  std::uint64_t slice_memory() const override { return inner_->slice_memory(); }

 protected:
  std::unique_ptr<Encoder> inner_;
};

class PainterDecorator : public Painter {
 public:
  explicit PainterDecorator(std::shared_ptr<Painter> inner) : inner_(std::move(inner)) {}
  bool prepare() override { return inner_->prepare(); }
  void skip(const PayloadToDraw& payload) override { inner_->skip(payload); }
  bool conclude() override { return inner_->conclude(); }
  void news(int gp, Bytes& news) override { inner_->news(gp, news); }
  ItemCounts counts() const override { return inner_->counts(); }
  double composite_seconds() const override { return inner_->composite_seconds(); }
  Bytes hand_over(int to) override { return inner_->hand_over(to); }
  void gather(int from, std::span<const std::byte> bytes) override { inner_->gather(from, bytes); }
  void finish(const std::function<void(int tile, Bytes bytes)>& deliver) override { inner_->finish(deliver); }

 protected:
  std::shared_ptr<Painter> inner_;
};

class EngineDecorator : public Engine {
 public:
  explicit EngineDecorator(std::unique_ptr<Engine> inner) : inner_(std::move(inner)) {}
  FramePlan plan(const Announcement& a) override { return inner_->plan(a); }
  std::unique_ptr<Canvas> canvas(const Announcement& a) override { return inner_->canvas(a); }

 protected:
  std::unique_ptr<Engine> inner_;
};

}  // namespace ringsplat
