#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <ranges>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "sheet_engine/block_windows.hpp"
#include "sheet_engine/layers.hpp"
#include "sheet_engine/place_map.hpp"
#include "sheet_engine/projection.hpp"
#include "sheet_engine/scalar_planes.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/sheet_rays.hpp"
#include "sheet_engine/slab_table.hpp"
#include "sheet_engine/visible_tiles.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// Slices that are kept before what lies between them is painted: many, so that a group of pixels goes
/// through many slabs at once, but no more than this memory.
constexpr std::size_t most_plane_bytes = std::size_t{64} << 20;
constexpr int least_slots = 8;
/// While a Renderer waits for slices it paints so many slabs or more, a group of pixels at a time, so that
/// other nodes of its rank need not wait.
constexpr std::size_t least_at_once = 12;
constexpr int groups_at_once = 16;

/// Draws sheets on a Renderer. A slab between the slices of two steps is painted once the slice behind them
/// is there or known not to come, together with as many others as there are.
class SheetPainter final : public FramePainter<SheetFrame> {
 public:
  using FramePainter::FramePainter;

  void begin_frame(std::shared_ptr<const SheetFrame> frame) override {
    FramePainter::begin_frame(std::move(frame));
    tiles_.lay_out(geometry().regions, images_.owned());
    rays_ = make_sheet_rays(*frame_);
    windows_.emplace(geometry());
    layers_.begin_frame(*frame_, renderer_);
    slabs_.clear();
    painting_ = 0;
    step_ = -1;
    payload_.reset();
    concluded_ = false;
    ready_ = false;
  }

  bool prepare() override {
    if (!ready_) {
      if (!range_) return false;
      make_ready();
      return true;
    }
    const std::size_t complete = complete_before(step_ + 1);
    if (painting_ == 0 && complete < least_at_once) return false;
    paint_some(complete, 1);
    return true;
  }

  void begin(const PayloadToDraw& payload) override {
    read(payload);
    step_ = payload.step;
    counts_.drawn += payload_->header.present;
    counts_.kept += payload_->kept;
    for (const BlockRow& row : payload_->rows) counts_.blocks += std::uint64_t(row.end - row.first);
  }

  bool work() override {
    if (make_room(step_)) return false;
    planes_.place(step_, *payload_, geometry().grid.type);
    if (step_ == 0) add_slab(-1, windows_->before_first);
    add_slab(step_, windows_->behind(step_));
    payload_.reset();
    return true;
  }

  void skip(const PayloadToDraw& payload) override {
    read(payload);
    planes_.keep(*payload_, geometry().grid.type);
    payload_.reset();
  }

  bool conclude() override {
    if (slabs_.empty()) return false;
    const int slices = geometry().slices;
    if (!concluded_) {
      if (make_room(slices)) return true;
      if (frame_->lit() && slabs_.back().step >= slices - 1)
        planes_.extrapolate(slices, slices - 1, std::max(slices - 2, 0));
      concluded_ = true;
    }
    paint_some(slabs_.size(), groups_at_once);
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
  void read(const PayloadToDraw& payload) {
    read_payload(payload.step, [&] {
      payload_ = read_sheet_payload(payload.body, rays_.voxels[0], rays_.voxels[1], geometry().grid.type);
      const std::uint16_t plane = payload_->header.plane;
      if (plane != no_plane && int(plane) >= geometry().slices)
        throw RunError(fmt::format("plane {} of {} slices", plane, geometry().slices));
    });
    take_range(payload_->header);
  }

  void take_range(const SheetHeader& header) {
    const bool known = std::isfinite(header.low) && std::isfinite(header.high) && header.low <= header.high;
    if (!known && is_whole(geometry().grid.type))
      throw OtherBuild(fmt::format("Renderer {} was told that the volume's values lie between {} and {}",
                                   renderer_, header.low, header.high));
    const std::pair told{header.low, header.high};
    if (ready_ && told == range_) return;
    range_ = told;
    make_ready();
  }

  /// Makes tables and planes for the frame and the volume's range.
  void make_ready() {
    ready_ = true;
    const Sheets& sheets = frame_->sheets;
    scale_ = value_scale(*frame_, range_->first, range_->second);
    const PlaneCode& code = scale_.code;
    if (frame_->composites()) fill_table();
    const int wide = rays_.voxels[0], high = rays_.voxels[1];
    const auto affordable = static_cast<int>(
        std::min<std::size_t>(most_plane_bytes / plane_bytes(wide, high, code), most_slices_kept));
    planes_.begin_frame(wide, high, std::clamp(affordable, least_slots, most_slices_kept), code,
                        make_fillers(frame_->transparent, geometry().grid.type, scale_.low, scale_.high));
    paint_ = {};
    paint_.rays = rays_;
    if (frame_->composites())
      paint_.places =
          frame_->nearest() ? place_map(*frame_, scale_, values_) : place_map(*frame_, scale_, table_.axis());
    make_tints();
    const double largest = std::max(std::abs(code.of(scale_.low)), std::abs(code.of(scale_.high)));
    paint_.light = code.floats ? gradient_light(*frame_, largest, code.scale)
                               : gradient_light(*frame_, 4095, code.scale / pair_unit);
    paint_.nearest = frame_->nearest();
    paint_.table = paint_.nearest ? values_.entries() : table_.entries();
    paint_.last_entry = paint_.nearest ? float(values_.last()) : TableAxis::last;
    if (!paint_.nearest && !table_.depths().empty()) paint_.depths = &table_.depths().front().whole;
    paint_.slab_length = float(slab_length());
    paint_.pitch = planes_.pitch();
    paint_.floats = code.floats;
    paint_.lit = frame_->lit();
    paint_.adaptive = sheets.adaptive && !frame_->shown.values;
    paint_.light_points = sheets.light_points;
    paint_.opaque_threshold = static_cast<float>(frame_->shown.opaque_threshold);
    paint_.face_pieces = 0.5F * float(frame_->slabs());
    paint_.projection = make_projection(*frame_, code);
    for (const LatticePlane& plane : geometry().clip_planes)
      paint_.clip_planes[std::size_t(paint_.clip_plane_count++)] = make_sheet_plane(plane, geometry());
  }

  void make_tints() {
    tints_.fill(0);
    for (const auto& [label, colour, share] : frame_->shown.tints)
      for (int c = 0; c < 4; ++c) tints_[std::size_t(4 * label + c)] = c < 3 ? colour[c] : share;
    if (scale_.code.labelled && frame_->composites()) paint_.tints = tints_.data();
  }

  void colour_projection() {
    // Nothing was taken where no GP had anything to say.
    if (!ready_) scale_ = {};
    const Projection projection = make_projection(*frame_, scale_.code);
    colours_.set_function(frame_->shown.transfer_function, frame_->shown.mode);
    // The place of a single slice is where a ray meets it.
    const SliceLabels labels = geometry().slices == 1 && step_ == 0 && scale_.code.labelled
                                   ? SliceLabels{planes_.labels(0), planes_.pitch(), tints_.data()}
                                   : SliceLabels{};
    std::atomic<std::size_t> next = 0;
    threads_.run(threads_.size(), [&](int) {
      for (std::size_t slot = next++; slot < images_.count(); slot = next++)
        colours_.colour(*frame_, rays_, projection, scale_.code, labels, images_.image(slot));
    });
  }

  double slab_length() const { return frame_->step_length() / frame_->slabs(); }

  /// The one that the frame uses.
  void fill_table() {
    const TransferFunction& tf = frame_->shown.transfer_function;
    if (frame_->nearest())
      values_.make(tf, scale_.low, scale_.high, is_whole(geometry().grid.type), slab_length());
    else
      table_.make(tf, scale_.low, scale_.high, slab_length());
  }

  /// Room for the slice of `step`: while there is none, paints some of what can be painted without it.
  /// Returns whether it did.
  bool make_room(int step) {
    if (slabs_.empty() || step - (slabs_.front().step - 2) < planes_.slots()) return false;
    paint_some(complete_before(step), groups_at_once);
    return true;
  }

  /// How many slabs can be painted without the slice of `step` or later ones.
  std::size_t complete_before(int step) const {
    std::size_t complete = 0;
    while (complete < slabs_.size() && slabs_[complete].step + 1 < step) ++complete;
    return complete;
  }

  void add_slab(int step, const BlockWindows& windows) {
    tiles_.add_slab();
    bool any = false;
    const int slice = geometry().slice_at(step_), layer = geometry().layer_of(slice);
    payload_->for_each_block([&](int column, int row, std::uint8_t byte) {
      if ((byte & cells_visible) != 0)
        any |= tiles_.mark(geometry().in_layer(windows.of(column, row, slice), layer));
    });
    if (!any) {
      tiles_.drop_slab();
      return;
    }
    counts_.samples += tiles_.marked() * tile_side * tile_side;
    slabs_.push_back(make_slab(*frame_, rays_, step));
  }

  /// Gives the first `count` slabs their planes.
  void find_planes(std::size_t count) {
    const int last = geometry().slices - 1;
    if (frame_->lit() && slabs_.front().step <= 1) planes_.extrapolate(-1, 0, std::min(1, last));
    for (std::size_t k = 0; k < count; ++k) {
      SheetSlab& slab = slabs_[k];
      const int back = std::min(slab.step, last), front = std::max(slab.step - 1, 0);
      slab.front = planes_.plane(front);
      slab.back = planes_.plane(back);
      slab.front_labels = planes_.labels(front);
      slab.back_labels = planes_.labels(back);
      slab.before = planes_.plane(slab.step == last + 1 ? last - 1 : front - 1);
      slab.after = planes_.plane(slab.step == 0 ? 1 : back + 1);
      // The one slice of a volume has itself on both sides.
      if (last == 0) slab.before = slab.after = slab.front;
    }
  }

  /// Paints up to `groups` groups of pixels on each thread, through the first `count` slabs or those that
  /// were begun before.
  void paint_some(std::size_t count, int groups) {
    if (painting_ == 0) {
      find_planes(count);
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
    slabs_.erase(slabs_.begin(), slabs_.begin() + std::ptrdiff_t(painting_));
    tiles_.drop_first(painting_);
    painting_ = 0;
  }

  /// Finds the groups that the slabs may show. Their images' memory is made before threads share them.
  void find_groups() {
    groups_.clear();
    for (std::size_t g = 0; g < tiles_.groups().size(); ++g) {
      const auto shows = [&](std::size_t slab) {
        return tiles_.masks_of(g)[std::ptrdiff_t(slab) * tiles_.stride()] != 0;
      };
      if (std::ranges::none_of(std::views::iota(std::size_t{0}, painting_), shows)) continue;
      groups_.push_back(g);
      images_.image(tiles_.groups()[g].slot).pixels();
    }
  }

  void paint_groups(std::size_t end) {
    for (std::size_t next = next_group_++; next < end; next = next_group_++) {
      const std::size_t g = groups_[next];
      const auto& group = tiles_.groups()[g];
      RegionImage& image = images_.image(group.slot);
      const PixelRect& rect = image.rect();
      const int x = group.column * group_side, y = group.row * group_side;
      const int above = geometry().layers.slices > 0 ? rect.y0 % geometry().layers.height : rect.y0;
      PixelGroup pixels{rect.x0 + x,
                        above + y,
                        std::min(group_side, rect.width() - x),
                        std::min(group_side, rect.height() - y),
                        image.pixels() + y * image.row_floats() + 4 * x,
                        image.row_floats()};
      paint_group(paint_, pixels, {std::span(slabs_).first(painting_), tiles_.masks_of(g), tiles_.stride()});
    }
  }

  VisibleTiles tiles_;
  LayerSum layers_;
  SheetRays rays_;
  std::optional<SlabWindows> windows_;
  ProjectionColours colours_;                       ///< where slabs are not composited
  std::optional<std::pair<double, double>> range_;  ///< the volume's values, as last told
  ValueScale scale_;
  SlabTable table_;
  ValueTable values_;  ///< instead, where values are the nearest voxels'
  ScalarPlanes planes_;
  SheetPaint paint_;
  TintTable tints_{};
  bool ready_ = false;  ///< tables and planes are the frame's
  std::optional<SheetPayload> payload_;
  int step_ = 0;
  std::vector<SheetSlab> slabs_;             ///< pending ones, front to back; masks in tiles_
  std::size_t painting_ = 0;                 ///< how many of them are being painted
  std::vector<std::size_t> groups_;          ///< those that they may show
  std::atomic<std::size_t> next_group_ = 0;  ///< in groups_
  bool concluded_ = false;                   ///< the last slice's surroundings are there
};

}  // namespace

std::unique_ptr<FramePainter<SheetFrame>> make_sheet_painter(int renderer, ThreadTeam& threads) {
  return std::make_unique<SheetPainter>(renderer, threads);
}

}  // namespace ringsplat
