#include "engine_parts/frame_engine.hpp"

#include "net/message.hpp"
#include "raster/warp_image.hpp"

namespace ringsplat {
namespace {

class PictureCanvas final : public Canvas {
 public:
  PictureCanvas(std::int64_t number, const Shown& shown, std::shared_ptr<const FrameGeometry> geometry,
                TakePicture take)
      : number_(number),
        width_(shown.width),
        height_(shown.height),
        geometry_(std::move(geometry)),
        take_(std::move(take)),
        image_(Image::uninitialised(geometry_->width, geometry_->height)),
        filled_{image_.width, image_.height, -1, -1},
        here_(std::size_t(geometry_->picture_regions().count())) {}

  void take(int tile, std::span<const std::byte> bytes) override {
    const PixelRect rect = geometry_->picture_regions().rect(tile);
    const std::size_t row_bytes = std::size_t(rect.width()) * 4 * sizeof(float);
    for (int y = 0; y < rect.height(); ++y)
      std::memcpy(image_.pixel(rect.x0, rect.y0 + y), bytes.data() + std::size_t(y) * row_bytes, row_bytes);
    filled_ = hull(filled_, {rect.x0, rect.y0, rect.x1 - 1, rect.y1 - 1});
    here_[std::size_t(tile)] = true;
  }

  void finish() override {
    // Clears only pixels without a tile, which are few.
    for (int region = 0; region < int(here_.size()); ++region) {
      if (here_[std::size_t(region)]) continue;
      const PixelRect rect = geometry_->picture_regions().rect(region);
      for (int y = rect.y0; y < rect.y1; ++y)
        std::fill(image_.pixel(rect.x0, y), image_.pixel(rect.x1, y), 0.0F);
    }
    if (const auto& warp = geometry_->warp) image_ = warp_image(image_, filled_, *warp, width_, height_);
    take_(number_, std::move(image_));
  }

 private:
  std::int64_t number_;
  int width_, height_;  ///< of the picture
  std::shared_ptr<const FrameGeometry> geometry_;
  TakePicture take_;
  Image image_;         ///< of the image plane
  PixelWindow filled_;  ///< part of it that tiles have filled
  std::vector<bool> here_;
};

/// What the protocol knows of a frame: slices are dealt in turn, and a tile is a region of the image plane.
FramePlan plan_of(const FrameGeometry& g, SliceDealing dealing, const std::vector<int>& tile_owners) {
  FramePlan plan;
  plan.ascending = g.traversal.ascending;
  // Owners are those of the whole volume's slices.
  const int first = g.box.first[static_cast<int>(g.traversal.axis)];
  plan.first_slice = first + g.slice_at(0);
  for (int step = 0; step < g.slices; ++step)
    plan.owners.push_back(dealing.owner_of(first + g.slice_at(step)));
  const Regions& regions = g.picture_regions();
  for (int region = 0; region < regions.count(); ++region) {
    const PixelRect rect = regions.rect(region);
    plan.tiles.push_back({tile_owners[std::size_t(region)],
                          std::size_t(rect.width()) * std::size_t(rect.height()) * 4 * sizeof(float)});
  }
  return plan;
}

}  // namespace

SharedFrame::SharedFrame(const FrameSpec& spec, FrameGeometry its_geometry, SliceDealing dealing,
                         int renderers, RegionDealer* dealer)
    : number(spec.frame), shown(spec.shown), geometry(std::move(its_geometry)) {
  if (dealer != nullptr) dealer->deal(spec, geometry);
  drawers = geometry.owners(renderers);
  plan = plan_of(geometry, dealing, geometry.layers.slices > 0 ? geometry.tile_owners(renderers) : drawers);
}

void RegionDealer::deal(const FrameSpec& spec, FrameGeometry& g) {
  if (!setup_.sketch || setup_.renderers < 2) return;
  const int dealt_to = g.dealt_to > 0 ? std::min(g.dealt_to, setup_.renderers) : setup_.renderers;
  const bool sheets = std::holds_alternative<Sheets>(spec.how);
  // Dealt in turn, so many for each Renderer give none much more work than others; neighbouring strips cost
  // nearly the same.
  const int enough_each = sheets ? 8 : 16;
  if (!setup_.colocated && !g.in_parts && spec.division.pace.empty() &&
      g.reached.width() * g.reached.height() >= enough_each * dealt_to)
    return;
  const WorkCosts costs = costs_in(g, sheets ? setup_.sheet_costs : setup_.splat_costs);
  const auto shown = shown_.of(*setup_.sketch, spec.shown.transfer_function, shown_blocks(g, costs));
  // As many points as are needed to compare the parts of so many Renderers. All ranks look at them before
  // each frame, also those that share a core.
  constexpr std::size_t for_each = 2000;
  // Odd, so that it goes across rows of an even number of points.
  const std::size_t step = shown.size() / (for_each * std::size_t(dealt_to)) | 1;
  std::vector<std::uint32_t> points;
  for (std::size_t k = 0; k < shown.size(); k += step) points.push_back(shown[k]);
  const WorkEstimate work(g, *setup_.sketch, points, costs, spec.shown.reduction.factor, -1, int(step));
  std::vector<double> busy(std::size_t(dealt_to), 0.0);
  if (setup_.colocated) busy = busy_ranks(g, work, costs, setup_.dealing(), setup_.renderers, dealt_to);
  deal_by_work(g, work, costs, spec, setup_.renderers, busy);
}

std::unique_ptr<Canvas> make_picture_canvas(std::int64_t number, const Shown& shown,
                                            std::shared_ptr<const FrameGeometry> geometry, TakePicture take) {
  return std::make_unique<PictureCanvas>(number, shown, std::move(geometry), std::move(take));
}

void OwnedImages::begin_frame(const Regions& regions, const std::vector<int>& drawers,
                              double opaque_threshold) {
  std::vector<int> owned;
  for (int region = 0; region < regions.count(); ++region)
    if (drawers[std::size_t(region)] == renderer_) owned.push_back(region);
  if (!(regions_ == regions && owned_ == owned)) {
    regions_ = regions;
    owned_ = std::move(owned);
    images_.clear();
    for (const int region : owned_) images_.emplace_back(regions.rect(region));
  }
  for (RegionImage& image : images_) image.begin_frame(static_cast<float>(opaque_threshold));
  told_.clear();
}

void OwnedImages::news(int gp, Bytes& news) {
  if (images_.empty()) return;
  auto& told = told_[gp];
  told.resize(images_.size(), 0);
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const OpaqueTiles& tiles = images_[k].opaque_tiles();
    if (tiles.opaque() == std::exchange(told[k], tiles.opaque())) continue;
    if (news.empty()) news = Message::body_buffer();
    append_opaque_news(owned_[k], tiles, news);
  }
}

void OwnedImages::deliver(const std::function<void(int, Bytes)>& deliver) const {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    if (!images_[k].touched()) continue;
    const PixelRect& rect = images_[k].rect();
    const std::size_t floats = std::size_t(4) * std::size_t(rect.width()) * std::size_t(rect.height());
    Bytes body(sizeof(Header) + floats * sizeof(float));
    images_[k].read_tile({reinterpret_cast<float*>(body.data() + sizeof(Header)), floats});
    deliver(owned_[k], std::move(body));
  }
}

}  // namespace ringsplat
