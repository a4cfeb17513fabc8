#include "protocol/bundle_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "protocol/engine_decorator.hpp"
#include "protocol/joined_step.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Which steps of the inner engine make a bundle.
class Bundles {
 public:
  Bundles(const FramePlan& of_slices, int bundle) {
    const int direction = of_slices.ascending ? 1 : -1;
    const auto bundle_of = [&](int step) { return (of_slices.first_slice + direction * step) / bundle; };
    for (int step = 0; step < of_slices.slices(); ++step)
      if (step == 0 || bundle_of(step) != bundle_of(step - 1)) begins_.push_back(step);
    begins_.push_back(of_slices.slices());
  }

  int count() const { return int(begins_.size()) - 1; }
  int begin(int bundle) const { return begins_[std::size_t(bundle)]; }
  int end(int bundle) const { return begins_[std::size_t(bundle) + 1]; }
  int slices(int bundle) const { return end(bundle) - begin(bundle); }
  int bundle_of(int slice_step) const {
    return int(std::upper_bound(begins_.begin(), begins_.end(), slice_step) - begins_.begin()) - 1;
  }

 private:
  std::vector<int> begins_;  ///< steps of slices, and the end of the last bundle
};

class BundleEncoder final : public EncoderDecorator {
 public:
  BundleEncoder(std::unique_ptr<Encoder> inner, int gp, const FramePlan& of_slices, Bundles bundles)
      : EncoderDecorator(std::move(inner)), bundles_(std::move(bundles)), slices_(inner_->shown()) {
    shows_nothing_ = slices_.empty();
    // A frame that shows nothing has one step nevertheless (Frame in gp.cpp).
    if (shows_nothing_) slices_.push_back(0);
    owned_ = std::size_t(std::count_if(slices_.begin(), slices_.end(),
                                       [&](int step) { return of_slices.owners[std::size_t(step)] == gp; }));
  }

  std::vector<int> shown() override {
    std::vector<int> steps;
    if (shows_nothing_) return steps;
    for (const int slice : slices_)
      if (const int bundle = bundles_.bundle_of(slice); steps.empty() || steps.back() != bundle)
        steps.push_back(bundle);
    return steps;
  }

  std::uint64_t left_out(std::size_t) const override { return inner_->left_out(owned_); }

  void begin(int bundle) override {
    const auto at = [this](int step) { return std::lower_bound(slices_.begin(), slices_.end(), step); };
    next_ = at(bundles_.begin(bundle));
    end_ = at(bundles_.end(bundle));
    joined_.begin();
    inner_->begin(*next_);
  }

  bool work() override {
    if (next_ == end_) return joined_.work();
    if (!inner_->work()) return false;
    joined_.add(*next_, inner_->finish());
    if (++next_ != end_) inner_->begin(*next_);
    return false;
  }

  EncodedStep finish() override { return joined_.take(); }

 private:
  Bundles bundles_;
  std::vector<int> slices_;  ///< steps of slices that are shown
  bool shows_nothing_ = false;
  std::size_t owned_ = 0;                  ///< how many of them this GP has
  std::vector<int>::iterator next_, end_;  ///< of slices_: the slice that is encoded, and the bundle's end
  JoinedStep joined_;                      ///< of the bundle's slices so far
};

class BundlePainter final : public PainterDecorator {
 public:
  BundlePainter(std::shared_ptr<Painter> inner, int renderer, Bundles bundles)
      : PainterDecorator(std::move(inner)), renderer_(renderer), bundles_(std::move(bundles)) {}

  void begin(const PayloadToDraw& payload) override {
    read(payload);
    next_ = 0;
    inner_->begin(slices_.front());
  }

  bool work() override {
    if (!inner_->work()) return false;
    if (++next_ == slices_.size()) return true;
    inner_->begin(slices_[next_]);
    return false;
  }

  void skip(const PayloadToDraw& payload) override {
    read(payload);
    for (const PayloadToDraw& slice : slices_) inner_->skip(slice);
  }

 private:
  /// Finds the payloads of the bundle's slices.
  void read(const PayloadToDraw& payload) {
    const std::span<const std::byte> body = payload.body;
    const bool known = payload.step >= 0 && payload.step < bundles_.count();
    if (!known || body.empty()) refuse(payload, "is no bundle of the frame's");
    int least = bundles_.begin(payload.step);
    slices_.clear();
    for (std::size_t at = 0; at < body.size();) {
      JoinedPart part;
      if (!take_part(body, at, part)) refuse(payload, "is cut short");
      if (part.number < least || part.number >= bundles_.end(payload.step))
        refuse(payload, fmt::format("has slice {} out of its place", part.number));
      least = part.number + 1;
      slices_.push_back({part.number, part.passes, body.subspan(at, part.bytes)});
      at += part.bytes;
    }
  }

  [[noreturn]] void refuse(const PayloadToDraw& payload, const std::string& why) const {
    throw RunError(
        fmt::format("Renderer {} got a payload of bundle {} that {}", renderer_, payload.step, why),
        "all ranks must run the same build with the same options");
  }

  int renderer_;
  Bundles bundles_;
  std::vector<PayloadToDraw> slices_;  ///< the payload's
  std::size_t next_ = 0;               ///< the slice that is drawn
};

class BundleEngine final : public EngineDecorator {
 public:
  BundleEngine(std::unique_ptr<Engine> inner, int bundle)
      : EngineDecorator(std::move(inner)), bundle_(bundle) {}

  FramePlan plan(const Announcement& a) override {
    FramePlan plan = inner_->plan(a);
    const Bundles bundles(plan, bundle_);
    const std::vector<int> of_slices = std::exchange(plan.owners, {});
    for (int bundle = 0; bundle < bundles.count(); ++bundle) {
      plan.owners.push_back(of_slices[std::size_t(bundles.begin(bundle))]);
      plan.slices_of_steps.push_back(bundles.slices(bundle));
    }
    for (auto& [first, end, takers] : plan.shares)
      if (first < end) first = bundles.bundle_of(first), end = bundles.bundle_of(end - 1) + 1;
    return plan;
  }
  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    const FramePlan of_slices = inner_->plan(a);
    return std::make_unique<BundleEncoder>(inner_->encoder(gp, a), gp, of_slices,
                                           Bundles(of_slices, bundle_));
  }

  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    return std::make_shared<BundlePainter>(inner_->painter(renderer, a), renderer,
                                           Bundles(inner_->plan(a), bundle_));
  }

 private:
  int bundle_;
};

}  // namespace

std::unique_ptr<Engine> make_bundle_engine(std::unique_ptr<Engine> inner, int bundle) {
  return std::make_unique<BundleEngine>(std::move(inner), bundle);
}

}  // namespace ringsplat
