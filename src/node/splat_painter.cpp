#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "ringsplat/base/clock.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/net/message.hpp"
#include "ringsplat/node/engine.hpp"
#include "ringsplat/splat/region_painter.hpp"

namespace ringsplat {
namespace {

/// The paper's engine on a Renderer: sums each slice's splats region by region and composites the slice behind the image.
class SplatPainter final : public Painter {
 public:
  SplatPainter(int renderer, int renderers) : renderer_(renderer), renderers_(renderers) {}

  void begin_frame(const FrameGeometry& geometry) override {
    if (!same_layout(geometry.regions)) {
      painters_.clear();
      slot_of_region_.assign(std::size_t(geometry.regions.count()), not_owned);
      owned_ = geometry.regions.owned(renderer_, renderers_);
      for (const int region : owned_) {
        const PixelRect r = geometry.regions.rect(region);
        slot_of_region_[std::size_t(region)] = painters_.size();
        painters_.emplace_back(r.x0, r.y0, r.width(), r.height());
      }
      regions_ = geometry.regions;
    }
    for (auto& painter : painters_) painter.begin_frame(geometry.footprint);
    counts_ = {};
    composite_seconds_ = 0;
  }

  void begin(std::span<const std::byte> body) override {
    body_ = body;
    at_ = 0;
    left_in_group_ = 0;
    touched_.clear();
    check_payload();
  }

  bool work() override {
    constexpr std::uint32_t splats_at_most = 8192;
    std::uint32_t budget = splats_at_most;
    while (budget > 0 && (left_in_group_ > 0 || at_ < body_.size())) {
      if (left_in_group_ == 0) next_group();
      const std::uint32_t count = std::min(budget, left_in_group_);
      const auto drawn = painter_of(group_.region).draw(group_.base_x, group_.base_y, body_.subspan(at_, count * sizeof(Splat)));
      counts_.drawn += drawn.drawn;
      counts_.clipped += drawn.clipped;
      at_ += count * sizeof(Splat);
      left_in_group_ -= count;
      budget -= count;
    }
    if (left_in_group_ > 0 || at_ < body_.size()) return false;

    const ScopedSeconds timed(composite_seconds_);
    for (const int region : touched_) painter_of(region).composite();
    return true;
  }

  PaintCounts counts() const override { return counts_; }
  double composite_seconds() const override { return composite_seconds_; }

  void finish(const std::function<void(int, Bytes)>& deliver) override {
    for (std::size_t k = 0; k < painters_.size(); ++k) {
      if (!painters_[k].touched()) continue;
      const int region = owned_[k];
      const PixelRect rect = regions_.rect(region);
      std::vector<float> rgba(std::size_t(4) * std::size_t(rect.width()) * std::size_t(rect.height()));
      painters_[k].read_tile(rgba);
      Bytes body(sizeof(Header) + rgba.size() * sizeof(float));
      std::memcpy(body.data() + sizeof(Header), rgba.data(), rgba.size() * sizeof(float));
      deliver(region, std::move(body));
    }
  }

 private:
  bool same_layout(const Regions& regions) const {
    return regions_.count() == regions.count() && regions_.count() > 0 && regions_.columns() == regions.columns() &&
           regions_.rect(regions.count() - 1) == regions.rect(regions.count() - 1) && regions_.region_size() == regions.region_size();
  }

  /// Walks the whole payload's groups before anything is drawn: a bad message leaves no half-drawn slice.
  void check_payload() const {
    std::size_t at = 0;
    while (at < body_.size()) {
      SplatGroup group;
      const bool whole = take(body_, at, group);
      if (!whole || group.region < 0 || group.region >= regions_.count() ||
          slot_of_region_[std::size_t(group.region)] == not_owned ||
          (body_.size() - at) / sizeof(Splat) < group.count)
        throw RunError(fmt::format("Renderer {} got a payload whose group at byte {} is no group of its own regions", renderer_, at),
                       "all ranks must run the same build");
      at += group.count * sizeof(Splat);
    }
  }

  void next_group() {
    if (!take(body_, at_, group_)) at_ = body_.size();
    left_in_group_ = group_.count;
    if (touched_.empty() || touched_.back() != group_.region) touched_.push_back(group_.region);
  }

  RegionPainter& painter_of(int region) { return painters_[slot_of_region_[std::size_t(region)]]; }

  int renderer_, renderers_;
  Regions regions_;
  static constexpr std::size_t not_owned = ~std::size_t{0};
  std::vector<int> owned_;                    ///< regions, ascending
  std::vector<RegionPainter> painters_;       ///< one for each owned region
  std::vector<std::size_t> slot_of_region_;   ///< into painters_
  std::span<const std::byte> body_;
  std::size_t at_ = 0;
  SplatGroup group_{};
  std::uint32_t left_in_group_ = 0;
  std::vector<int> touched_;  ///< regions of this slice
  PaintCounts counts_;
  double composite_seconds_ = 0;
};

}  // namespace

std::unique_ptr<Painter> make_painter(int renderer, int renderers) { return std::make_unique<SplatPainter>(renderer, renderers); }

}  // namespace ringsplat
