#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "node/opaque_news.hpp"
#include "node/payload_reader.hpp"
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

  void begin_frame(const FrameSpec& spec, const FrameGeometry& geometry) override {
    if (!same_layout(geometry.regions)) lay_out(geometry.regions);
    geometry_ = geometry;
    const FrameKernel kernel = make_frame_kernel(geometry.footprint, geometry.view, geometry.traversal.axis, spec.kernel);
    for (auto& painter : painters_) painter.begin_frame(kernel, static_cast<float>(spec.opaque_threshold));
    reader_ = make_reader(spec, kernel);
    told_.clear();
    counts_ = {};
    composite_seconds_ = 0;
  }

  void begin(int step, std::span<const std::byte> body) override {
    const auto owned = [this](int region) {
      return region >= 0 && region < regions_.count() && slot_of_region_[std::size_t(region)] != not_owned;
    };
    try {
      reader_->begin(geometry_.traversal.slice_at(step, geometry_.slices), body, owned);
    } catch (const RunError& e) {
      throw RunError(fmt::format("Renderer {}, step {}: {}", renderer_, step, e.what()));
    }
    voxel_ = voxel_of_step(step);
    drawing_.reset();
  }

  bool work() override {
    constexpr std::int64_t splats_at_most = 1024, chunk_splats = 512;
    for (std::int64_t budget = splats_at_most; budget > 0;) {
      const std::optional<int> region = reader_->region();
      if (!region) {
        composite();
        return true;
      }
      if (drawing_ != region) composite();
      drawing_ = region;
      const DrawCounts drawn = reader_->draw(painter_of(*region), std::uint32_t(std::min(budget, chunk_splats)));
      counts_.drawn += drawn.drawn;
      counts_.clipped += drawn.clipped;
      counts_.hidden += drawn.hidden;
      budget -= std::int64_t(drawn.drawn + drawn.clipped + drawn.hidden);
    }
    return false;
  }

  void opaque_news(int gp, Bytes& news) override {
    if (painters_.empty()) return;
    auto& told = told_[gp];
    told.resize(painters_.size(), 0);
    for (std::size_t k = 0; k < painters_.size(); ++k) {
      const OpaqueTiles& tiles = painters_[k].opaque_tiles();
      if (tiles.opaque() == std::exchange(told[k], tiles.opaque())) continue;
      if (news.empty()) news = Message::body_buffer();
      append_opaque_news(owned_[k], tiles, news);
    }
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
  std::unique_ptr<PayloadReader> make_reader(const FrameSpec& spec, const FrameKernel& kernel) const {
    if (spec.payload == PayloadForm::words) return make_word_reader();
    auto aligned = make_aligned_reader(spec, geometry_, kernel);
    return aligned ? std::move(aligned) : make_run_reader(spec, geometry_);
  }

  bool same_layout(const Regions& regions) const {
    return regions_.count() == regions.count() && regions_.count() > 0 && regions_.columns() == regions.columns() &&
           regions_.rect(regions.count() - 1) == regions.rect(regions.count() - 1) && regions_.region_size() == regions.region_size();
  }

  void lay_out(const Regions& regions) {
    regions_ = regions;
    painters_.clear();
    slot_of_region_.assign(std::size_t(regions.count()), not_owned);
    owned_ = regions.owned(renderer_, renderers_);
    const auto memory = make_slice_memory();
    for (const int region : owned_) {
      const PixelRect r = regions.rect(region);
      slot_of_region_[std::size_t(region)] = painters_.size();
      painters_.emplace_back(r.x0, r.y0, r.width(), r.height(), memory);
    }
  }

  /// Regions share a slice buffer: one is composited before the next is drawn.
  void composite() {
    if (!drawing_) return;
    const ScopedSeconds timed(composite_seconds_);
    painter_of(*drawing_).composite(voxel_);
    drawing_.reset();
  }

  /// Where a voxel of the slice lies on the screen.
  glm::dvec2 voxel_of_step(int step) const {
    glm::dvec3 voxel(0.0);
    voxel[static_cast<int>(geometry_.traversal.axis)] = geometry_.traversal.slice_at(step, geometry_.slices);
    return geometry_.view.project(voxel);
  }

  RegionPainter& painter_of(int region) { return painters_[slot_of_region_[std::size_t(region)]]; }

  int renderer_, renderers_;
  FrameGeometry geometry_;
  Regions regions_;
  static constexpr std::size_t not_owned = ~std::size_t{0};
  std::vector<int> owned_;                   ///< regions, ascending
  std::vector<RegionPainter> painters_;      ///< one for each owned region
  std::vector<std::size_t> slot_of_region_;  ///< into painters_
  std::unique_ptr<PayloadReader> reader_;
  glm::dvec2 voxel_{0.0};                    ///< of the slice
  std::optional<int> drawing_;             ///< region whose slice buffer is in use
  std::map<int, std::vector<int>> told_;   ///< by GP: how many opaque tiles of each owned region it knows
  PaintCounts counts_;
  double composite_seconds_ = 0;
};

}  // namespace

std::unique_ptr<Painter> make_painter(int renderer, int renderers) {
  return std::make_unique<SplatPainter>(renderer, renderers);
}

}  // namespace ringsplat
