#include "sheet_engine/painted_volume.hpp"

#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_rays.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// Slices that are kept before what lies between them is painted: many, so that a group of pixels goes
/// through many slabs at once, but no more than this memory, of all volumes.
constexpr std::size_t most_plane_bytes = std::size_t{64} << 20;
constexpr int least_slots = 8;

}  // namespace

void PaintedVolume::begin_frame(std::shared_ptr<const SheetFrame> frame, const SheetRays& rays,
                                const std::vector<int>& owned, std::size_t volumes) {
  frame_ = std::move(frame);
  volumes_ = volumes;
  rays_ = &rays;
  tiles.lay_out(geometry().regions, owned);
  windows_.emplace(geometry(), frame_->reach(), frame_->reach(), frame_->reach());
  constexpr std::int64_t far_away = std::int64_t{1} << 40;
  pixels_ = {far_away, far_away, -far_away, -far_away};
  const Regions& picture = geometry().picture_regions();
  for (const int region : owned) {
    const PixelRect rect = picture.rect(region % picture.count());  // layers lie one below another
    // Groups of pixels are painted together.
    pixels_ = hull(pixels_,
                   {rect.x0 - group_side, rect.y0 - group_side, rect.x1 + group_side, rect.y1 + group_side});
  }
  slabs.clear();
  payload.reset();
  ready_ = false;
}

PixelRect PaintedVolume::blocks_seen(int step) const {
  return windows_->blocks_in(pixels_, geometry().slice_at(step), CellRanges::blocks_along(rays_->voxels[0]),
                             CellRanges::blocks_along(rays_->voxels[1]));
}

bool PaintedVolume::prepare() {
  if (ready_ || !range_) return false;
  make_ready();
  return true;
}

void PaintedVolume::read(std::span<const std::byte> body, int renderer) {
  payload = read_sheet_payload(body, rays_->voxels[0], rays_->voxels[1], type());
  const SheetHeader& header = payload->header;
  if (header.plane != no_plane && int(header.plane) >= geometry().slices)
    throw RunError(fmt::format("plane {} of {} slices", header.plane, geometry().slices));
  const bool known = std::isfinite(header.low) && std::isfinite(header.high) && header.low <= header.high;
  if (!known && is_whole(type()))
    throw OtherBuild(fmt::format("Renderer {} was told that the volume's values lie between {} and {}",
                                 renderer, header.low, header.high));
  const std::pair told{header.low, header.high};
  if (ready_ && told == range_) return;
  range_ = told;
  make_ready();
}

bool PaintedVolume::mark_tiles(const BlockWindows& windows, int slice) {
  bool any = false;
  const int layer = geometry().layer_of(slice);
  payload->for_each_block([&](int column, int row, std::uint8_t byte) {
    if ((byte & cells_visible) != 0)
      any |= tiles.mark(geometry().in_layer(windows.of(column, row, slice), layer));
  });
  return any;
}

void PaintedVolume::find_planes(std::size_t count) {
  if (!ready_) return;
  const int last = geometry().slices - 1;
  if (frame_->lit() && slabs.front().step <= 1) planes_.extrapolate(-1, 0, std::min(1, last), blocks_seen(0));
  for (SheetSlab& slab : std::span(slabs).first(count)) {
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

void PaintedVolume::extrapolate_end() {
  const int slices = geometry().slices;
  if (frame_->lit() && slabs.back().step >= slices - 1)
    planes_.extrapolate(slices, slices - 1, std::max(slices - 2, 0), blocks_seen(slices - 1));
}

/// Makes tables and planes for the frame and the volume's range.
void PaintedVolume::make_ready() {
  ready_ = true;
  scale_ = value_scale(*frame_, range_->first, range_->second);
  const PlaneCode& code = scale_.code;
  if (frame_->composites()) fill_table();
  const int wide = rays_->voxels[0], high = rays_->voxels[1];
  const auto affordable = static_cast<int>(
      std::min<std::size_t>(most_plane_bytes / volumes_ / plane_bytes(wide, high, code), most_slices_kept));
  planes_.begin_frame(wide, high, std::clamp(affordable, least_slots, most_slices_kept), code,
                      make_fillers(frame_->transparent, type(), scale_.low, scale_.high));
  paint_ = {};
  paint_.rays = *rays_;
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
  paint_.adaptive = frame_->sheets.adaptive && !frame_->shown.values;
  paint_.light_points = frame_->sheets.light_points;
  paint_.opaque_threshold = static_cast<float>(frame_->shown.opaque_threshold);
  paint_.face_pieces = 0.5F * float(frame_->slabs());
  paint_.projection = make_projection(*frame_, scale_);
  for (const LatticePlane& plane : geometry().clip_planes)
    paint_.clip_planes[std::size_t(paint_.clip_plane_count++)] = make_sheet_plane(plane, geometry());
}

void PaintedVolume::make_tints() {
  tints_.fill(0);
  for (const auto& [label, colour, share] : frame_->shown.tints)
    for (int c = 0; c < 4; ++c) tints_[std::size_t(4 * label + c)] = c < 3 ? colour[c] : share;
  if (scale_.code.labelled && frame_->composites()) paint_.tints = tints_.data();
}

/// The one that the frame uses.
void PaintedVolume::fill_table() {
  const TransferFunction& tf = frame_->shown.transfer_function;
  if (frame_->nearest())
    values_.make(tf, scale_.low, scale_.high, is_whole(type()), slab_length());
  else
    table_.make(tf, scale_.low, scale_.high, slab_length());
}

ProjectedVolume PaintedVolume::projected(int last_step) {
  // Nothing was taken where no GP had anything to say.
  if (!ready_) scale_ = {};
  colours_.set_function(frame_->shown.transfer_function, frame_->shown.mode);
  // The place of a single slice is where a ray meets it.
  const SliceLabels labels = geometry().slices == 1 && last_step == 0 && scale_.code.labelled
                                 ? SliceLabels{planes_.labels(0), planes_.pitch(), tints_.data()}
                                 : SliceLabels{};
  return {*frame_, colours_, make_projection(*frame_, scale_), scale_, labels};
}

}  // namespace ringsplat
