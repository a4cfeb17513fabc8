#include <algorithm>
#include <atomic>
#include <map>
#include <ranges>
#include <utility>
#include <vector>

#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "protocol/joined_step.hpp"
#include "sheet_engine/layers.hpp"
#include "sheet_engine/painted_volume.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_rays.hpp"

namespace ringsplat {
namespace {

/// While a Renderer waits for slices it paints so many slabs or more, a group of pixels at a time, so that
/// other nodes of its rank need not wait.
constexpr std::size_t least_at_once = 12;
constexpr int groups_at_once = 16;
/// Values of so many volumes fit into a pixel of an image.
constexpr std::size_t values_an_image = 3;

/// Draws sheets on a Renderer, of one volume or of several that are painted along the same rays. A slab
/// between the slices of two steps is painted once the slice behind them is there or known not to come,
/// together with as many others as there are.
class SheetPainter final : public FramePainter<SheetFrame> {
 public:
  SheetPainter(int renderer, ThreadTeam& threads) : FramePainter(renderer, threads), more_(renderer) {}

  void begin_frame(std::shared_ptr<const SheetFrame> frame) override {
    FramePainter::begin_frame(std::move(frame));
    rays_ = make_sheet_rays(*frame_);
    windows_.emplace(geometry());
    layers_.begin_frame(*frame_, renderer_);
    const auto frames = channels_of(frame_);
    shown_.clear();
    for (const auto& one : frames) {
      shown_.push_back(&volumes_[one->volume]);
      shown_.back()->begin_frame(one, rays_, images_.owned(), frames.size());
    }
    if (has_more()) more_.begin_frame(geometry().regions, frame_->drawers, frame_->shown.opaque_threshold);
    painting_ = 0;
    step_ = -1;
    concluded_ = false;
  }

  bool prepare() override {
    for (PaintedVolume* volume : shown_)
      if (volume->prepare()) return true;
    const std::size_t complete = complete_before(step_ + 1);
    if (painting_ == 0 && complete < least_at_once) return false;
    paint_some(complete, 1);
    return true;
  }

  void begin(const PayloadToDraw& payload) override {
    read(payload);
    step_ = payload.step;
    for (const PaintedVolume* volume : shown_) {
      if (!volume->payload) continue;
      const SheetPayload& its = *volume->payload;
      counts_.drawn += its.header.present;
      counts_.kept += its.kept;
      for (const BlockRow& row : its.rows) counts_.blocks += std::uint64_t(row.end - row.first);
    }
  }

  bool work() override {
    if (make_room(step_)) return false;
    for (PaintedVolume* volume : shown_)
      if (volume->payload) volume->place(step_);
    if (step_ == 0) add_slab(-1, windows_->before_first);
    add_slab(step_, windows_->behind(step_));
    forget_payload();
    return true;
  }

  void skip(const PayloadToDraw& payload) override {
    read(payload);
    for (PaintedVolume* volume : shown_)
      if (volume->payload) volume->keep();
    forget_payload();
  }

  bool conclude() override {
    if (pending().empty()) return false;
    if (!concluded_) {
      if (make_room(geometry().slices)) return true;
      for (PaintedVolume* volume : shown_)
        if (volume->ready()) volume->extrapolate_end();
      concluded_ = true;
    }
    paint_some(pending().size(), groups_at_once);
    return true;
  }

  Bytes hand_over(int to) override {
    Bytes bytes = Message::body_buffer();
    append_layers(*frame_, images_, to, bytes);
    return bytes;
  }
  void gather(int, std::span<const std::byte> bytes) override { layers_.add(bytes); }

  void finish(const std::function<void(int, Bytes)>& deliver) override {
    if (!frame_->composites() || frame_->shown.values) colour_projection();
    if (geometry().layers.slices > 0)
      layers_.deliver(deliver);
    else
      FramePainter::finish(deliver);
  }

 private:
  const std::vector<SheetSlab>& pending() const { return shown_.front()->slabs; }

  void read(const PayloadToDraw& payload) {
    read_payload(payload.step, [&] {
      if (shown_.size() == 1) return shown_.front()->read(payload.body, renderer_);
      JoinedPart part;
      int least = 0;
      for (std::size_t at = 0; at < payload.body.size(); at += part.bytes) {
        if (!take_part(payload.body, at, part) || part.number < least || part.number >= int(shown_.size()))
          throw OtherBuild("a payload of several volumes cannot be read");
        shown_[std::size_t(part.number)]->read(payload.body.subspan(at, part.bytes), renderer_);
        least = part.number + 1;
      }
    });
  }
  void forget_payload() {
    for (PaintedVolume* volume : shown_) volume->payload.reset();
  }

  void colour_projection() {
    std::vector<ProjectedVolume> projected;
    for (PaintedVolume* volume : shown_) projected.push_back(volume->projected(step_));
    std::atomic<std::size_t> next = 0;
    threads_.run(threads_.size(), [&](int) {
      for (std::size_t slot = next++; slot < images_.count(); slot = next++)
        colour_region(projected, rays_, images_.image(slot), more_of(slot));
    });
  }
  /// Where a pixel's further values are; null: nowhere.
  RegionImage* more_of(std::size_t slot) { return has_more() ? &more_.image(slot) : nullptr; }
  bool has_more() const { return !frame_->composites() && shown_.size() > values_an_image; }

  /// Room for the slice of `step`: while there is none, paints some of what can be painted without it.
  /// Returns whether it did.
  bool make_room(int step) {
    if (pending().empty()) return false;
    int slots = most_slices_kept;
    for (const PaintedVolume* volume : shown_)
      if (volume->ready()) slots = std::min(slots, volume->slots());
    if (step - (pending().front().step - 2) < slots) return false;
    paint_some(complete_before(step), groups_at_once);
    return true;
  }

  /// How many slabs can be painted without the slice of `step` or later ones.
  std::size_t complete_before(int step) const {
    std::size_t complete = 0;
    while (complete < pending().size() && pending()[complete].step + 1 < step) ++complete;
    return complete;
  }

  void add_slab(int step, const BlockWindows& windows) {
    bool any = false;
    for (PaintedVolume* volume : shown_) {
      volume->tiles.add_slab();
      if (volume->payload) any |= volume->mark_tiles(windows, geometry().slice_at(step_));
    }
    for (PaintedVolume* volume : shown_) {
      if (!any) {
        volume->tiles.drop_slab();
        continue;
      }
      counts_.samples += volume->tiles.marked() * tile_side * tile_side;
      volume->slabs.push_back(make_slab(volume->frame(), rays_, step));
    }
  }

  /// Paints up to `groups` groups of pixels on each thread, through the first `count` slabs or those that
  /// were begun before.
  void paint_some(std::size_t count, int groups) {
    if (painting_ == 0) {
      for (PaintedVolume* volume : shown_) volume->find_planes(count);
      painting_ = count;
      next_group_ = 0;
      find_groups();
    }
    const auto lanes = std::min(std::size_t(threads_.size()), groups_.size() - next_group_);
    const std::size_t end = std::min(next_group_ + lanes * std::size_t(groups), groups_.size());
    threads_.run(int(lanes), [this, end](int) { paint_groups(end); });
    next_group_ = end;
    if (end < groups_.size()) return;
    for (std::size_t slot = 0; slot < images_.count(); ++slot)
      if (images_.image(slot).touched()) images_.image(slot).slices_composited(int(painting_));
    for (PaintedVolume* volume : shown_) {
      volume->slabs.erase(volume->slabs.begin(), volume->slabs.begin() + std::ptrdiff_t(painting_));
      volume->tiles.drop_first(painting_);
    }
    painting_ = 0;
  }

  /// Finds the groups that the slabs may show. Their images' memory is made before threads share them.
  void find_groups() {
    groups_.clear();
    const auto& all = shown_.front()->tiles.groups();
    for (std::size_t g = 0; g < all.size(); ++g) {
      const auto shows = [&](const PaintedVolume* volume) {
        const MaskedSlabs slabs = slabs_of(*volume, g);
        return std::ranges::any_of(std::views::iota(std::ptrdiff_t{0}, std::ptrdiff_t(painting_)),
                                   [&](auto k) { return slabs.masks[k * slabs.stride] != 0; });
      };
      if (std::ranges::none_of(shown_, shows)) continue;
      groups_.push_back(g);
      images_.image(all[g].slot).pixels();
      if (RegionImage* more = more_of(all[g].slot)) more->pixels();
    }
  }
  MaskedSlabs slabs_of(const PaintedVolume& volume, std::size_t group) const {
    return {std::span(volume.slabs).first(painting_), volume.tiles.masks_of(group), volume.tiles.stride()};
  }

  void paint_groups(std::size_t end) {
    for (std::size_t next = next_group_++; next < end; next = next_group_++) {
      const std::size_t g = groups_[next];
      const auto& group = shown_.front()->tiles.groups()[g];
      RegionImage& image = images_.image(group.slot);
      const PixelRect& rect = image.rect();
      const int x = group.column * group_side, y = group.row * group_side;
      const int above = geometry().layers.slices > 0 ? rect.y0 % geometry().layers.height : rect.y0;
      const std::ptrdiff_t first = y * image.row_floats() + 4 * x;
      RegionImage* const more = more_of(group.slot);
      paint(g, {rect.x0 + x, above + y, std::min(group_side, rect.width() - x),
                std::min(group_side, rect.height() - y), image.pixels() + first, image.row_floats(),
                more != nullptr ? more->pixels() + first : nullptr});
    }
  }

  void paint(std::size_t g, const PixelGroup& pixels) const {
    if (shown_.size() == 1) return paint_group(shown_.front()->paint(), pixels, slabs_of(*shown_.front(), g));
    std::vector<PaintedChannel> channels;
    for (std::size_t k = 0; k < shown_.size(); ++k)
      if (shown_[k]->ready()) channels.push_back({&shown_[k]->paint(), slabs_of(*shown_[k], g), int(k)});
    if (frame_->composites()) return mix_group(channels, pixels);
    // Volumes of floats have planes of another kind than those of few whole numbers.
    const auto floats = std::ranges::stable_partition(
        channels, [](const PaintedChannel& channel) { return !channel.paint->floats; });
    for (const std::span alike : {std::span(channels.begin(), floats.begin()), std::span(floats)})
      if (!alike.empty()) paint_channels(alike, shown_.size(), pixels);
  }

  std::map<std::size_t, PaintedVolume> volumes_;  ///< by number
  std::vector<PaintedVolume*> shown_;             ///< in the frame
  OwnedImages more_;                              ///< further values of the images' pixels
  LayerSum layers_;
  SheetRays rays_;
  std::optional<SlabWindows> windows_;
  int step_ = 0;
  std::size_t painting_ = 0;                 ///< how many of the pending slabs are being painted
  std::vector<std::size_t> groups_;          ///< those that they may show
  std::atomic<std::size_t> next_group_ = 0;  ///< in groups_
  bool concluded_ = false;                   ///< the last slice's surroundings are there
};

}  // namespace

std::unique_ptr<FramePainter<SheetFrame>> make_sheet_painter(int renderer, ThreadTeam& threads) {
  return std::make_unique<SheetPainter>(renderer, threads);
}

}  // namespace ringsplat
