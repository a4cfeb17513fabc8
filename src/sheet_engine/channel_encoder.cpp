#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "protocol/joined_step.hpp"
#include "sheet_engine/sheet_engine.hpp"

namespace ringsplat {
namespace {

/// Encodes a GP's slices of several volumes together: a Renderer's payload is those of all volumes, joined.
class ChannelEncoder final : public Encoder {
 public:
  explicit ChannelEncoder(std::vector<std::unique_ptr<Encoder>> volumes) : volumes_(std::move(volumes)) {
    for (const auto& volume : volumes_) shown_.push_back(volume->shown());
  }

  std::vector<int> shown() override {
    std::set<int> steps;
    for (const std::vector<int>& more : shown_) steps.insert(more.begin(), more.end());
    return {steps.begin(), steps.end()};
  }
  std::uint64_t left_out(std::size_t steps) const override {
    std::uint64_t voxels = 0;
    for (const auto& volume : volumes_) voxels += volume->left_out(steps);
    return voxels;
  }
  std::uint64_t slice_memory() const override {
    std::uint64_t bytes = 0;
    for (const auto& volume : volumes_) bytes += volume->slice_memory();
    return bytes;
  }
  void take_news(std::span<const std::byte> news) override {
    for (const auto& volume : volumes_) volume->take_news(news);
  }

  void begin(int step) override {
    joined_.begin();
    step_ = step;
    at_ = 0;
    begin_next();
  }
  bool work() override {
    if (at_ == volumes_.size()) return joined_.work();
    if (!volumes_[at_]->work()) return false;
    joined_.add(int(at_), volumes_[at_]->finish());
    ++at_;
    begin_next();
    return false;
  }
  EncodedStep finish() override { return joined_.take(); }

 private:
  /// The next volume that shows something of the step's slice.
  void begin_next() {
    while (at_ < volumes_.size() && !std::ranges::binary_search(shown_[at_], step_)) ++at_;
    if (at_ < volumes_.size()) volumes_[at_]->begin(step_);
  }

  std::vector<std::unique_ptr<Encoder>> volumes_;
  std::vector<std::vector<int>> shown_;  ///< by volume
  int step_ = 0;
  std::size_t at_ = 0;  ///< the volume that is encoded
  JoinedStep joined_;
};

}  // namespace

std::unique_ptr<Encoder> make_channel_encoder(std::vector<std::unique_ptr<Encoder>> volumes) {
  return std::make_unique<ChannelEncoder>(std::move(volumes));
}

}  // namespace ringsplat
