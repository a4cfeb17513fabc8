#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "base/thread_team.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "sheet_engine/kept_blocks.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "simulate/charge.hpp"
#include "simulate/meter.hpp"
#include "sort_last/section_painter.hpp"
#include "volume/cell_ranges.hpp"
#include "volume/clipped.hpp"

namespace ringsplat::sort_last {
namespace {

/// Slices to either side whose ranges say which blocks a slice that is drawn needs, and which of those are
/// drawn: one in front of the first own one and two behind the last.
constexpr int ranges_around = 2, drawn_before = 1, drawn_behind = 2;

/// A section and what is read around it.
VoxelBox box_around(const Grid& grid, Axis axis, const Section& section) {
  constexpr int around = ranges_around + drawn_behind;
  VoxelBox box = whole_box(grid);
  const int k = static_cast<int>(axis);
  box.first[k] = std::max(section.first - around, 0);
  box.end[k] = std::min(section.end + around, grid.slices(axis));
  return box;
}

SliceStore read_part(VolumeSource& whole, const VoxelBox& box, Axis axis) {
  const auto source = clipped_source(whole, box);
  const Grid& grid = source->grid();
  SliceStore store(grid, 0, 1, {axis == Axis::x, axis == Axis::y, axis == Axis::z}, false);
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z)), columns;
  for (int z = 0; z < grid.dims.z; ++z) {
    source->read_slices(z, 1, slice);
    if (axis == Axis::z) {
      std::memcpy(store.values(axis, z).data(), slice.data(), slice.size());
      continue;
    }
    columns.clear();
    pack_columns(grid, axis, 0, 1, slice, {}, columns);
    store.unpack_columns(axis, z, columns);
  }
  for (int s = 0; s < grid.slices(axis); ++s)
    store.know_cell_ranges(axis, s, std::make_shared<const CellRanges>(store.slice(axis, s)));
  return store;
}

/// The frame of the whole volume, told of the slices in the box as if there were no others. What an encoder
/// does with it is what it does with these slices of the whole.
std::shared_ptr<const SheetFrame> part_of(const SheetFrame& whole, const VoxelBox& box) {
  auto part = std::make_shared<SheetFrame>(whole);
  FrameGeometry& g = part->geometry;
  g.view.offset = g.view.project(glm::dvec3(box.first));
  if (g.view.eye) *g.view.eye -= glm::dvec3(box.first);
  g.grid = clipped_grid(g.grid, box);
  g.box = whole_box(g.grid);
  g.slices = g.grid.slices(g.traversal.axis);
  return part;
}

class SheetSection final : public SectionPainter {
 public:
  SheetSection(const SectionSetup& setup, Axis axis, double low, double high)
      : setup_(setup),
        axis_(axis),
        whole_(setup.source.grid()),
        box_(box_around(whole_, axis, setup.section)) {
    if (setup.section.slices() < 1) return;
    store_ = read_part(setup.source, box_, axis);
    SliceRanges ranges;
    ranges[std::size_t(axis)].push_back({axis, 0, low, high});
    store_.know_ranges(std::make_shared<const SliceRanges>(ranges));
  }

  Drawn draw(const FrameSpec& spec, Image& picture) override {
    Drawn drawn;
    drawn.costs.resize(std::size_t(whole_.slices(axis_)));
    if (setup_.section.slices() < 1) return drawn;
    const auto frame = make_sheet_frame(spec, whole_, 1, 1);
    if (frame->geometry.traversal.axis != axis_)
      throw InputError("the view does not traverse the slices of which the sections are",
                       "use a smaller --turn");
    const auto part = part_of(*make_sheet_frame(counted(spec), whole_, 1, 1), box_);
    const auto encoder =
        make_sheet_encoder(part, 1, store_, blocks_, false, setup_.machine ? nullptr : &kept_);
    const Meter meter = setup_.machine ? make_sheet_meter(part) : nullptr;
    if (!painter_) painter_ = make_sheet_painter(0, threads_);
    painter_->begin_frame(frame);
    if (const auto& m = setup_.machine) drawn.seconds = m->gp.frame + m->renderer.frame + m->sheets.table;
    const auto [first, end] = own_steps(frame->geometry);
    for (int step = std::max(first - drawn_before, 0);
         step < std::min(end + drawn_behind, frame->geometry.slices); ++step)
      draw_step(step, step >= first && step < end, *frame, *part, *encoder, meter, drawn);
    while (painter_->conclude()) continue;
    finish(*painter_, frame->geometry.regions, setup_, picture, drawn);
    placed_ = true;
    // Simulated ranks draw one after another, so that one of them only needs planes.
    if (setup_.machine) painter_.reset();
    charge(drawn.seconds);
    return drawn;
  }

  std::uint64_t slice_memory() const override { return store_.allocated_bytes(); }

 private:
  /// The frame whose costs are counted: with as many pixels as those that are drawn stand for.
  FrameSpec counted(FrameSpec spec) const {
    const auto side = int(std::lround(std::sqrt(setup_.pixel_weight)));
    spec.shown.width *= side;
    spec.shown.height *= side;
    return spec;
  }

  std::pair<int, int> own_steps(const FrameGeometry& whole) const {
    const Section& s = setup_.section;
    return whole.traversal.ascending ? std::pair(s.first, s.end)
                                     : std::pair(whole.slices - s.end, whole.slices - s.first);
  }

  void draw_step(int step, bool own, const SheetFrame& frame, const SheetFrame& part, Encoder& encoder,
                 const Meter& meter, Drawn& drawn) {
    const int slice = frame.geometry.slice_at(step), local = slice - box_.first[static_cast<int>(axis_)],
              local_step = part.geometry.traversal.slice_at(local, part.geometry.slices);
    encoder.begin(local_step);
    while (!encoder.work()) continue;
    EncodedStep encoded = encoder.finish();
    EncodedPart& sent = encoded.parts.front();
    if (!own && !sent.payload.empty()) hide_cells(sent.payload, part.geometry.grid);
    const PaintWork work = meter ? meter(local_step, encoded.parts).front() : PaintWork{};
    const std::uint64_t samples = painter_->counts().samples;
    if (!sent.payload.empty()) {
      painter_->begin({step, sent.passes, std::span<const std::byte>(sent.payload).subspan(sizeof(Header))});
      while (!painter_->work()) continue;
      while (painter_->prepare()) continue;
    }
    const double cost = cost_of(encoded, work, double(painter_->counts().samples - samples));
    if (setup_.machine) drawn.seconds += cost;
    if (own) {
      drawn.costs[std::size_t(slice)] = cost;
      drawn.items += double(sent.items);
    }
    Bytes news;
    painter_->news(0, news);
    if (!news.empty()) encoder.take_news(std::span<const std::byte>(news).subspan(sizeof(Header)));
  }

  /// What lies behind another section's slice is drawn there.
  void hide_cells(Bytes& message, const Grid& grid) const {
    const std::span<std::byte> body = std::span(message).subspan(sizeof(Header));
    const SheetPayload payload =
        read_sheet_payload(body, grid.slice_width(axis_), grid.slice_height(axis_), grid.type);
    for (std::size_t row = 0; row < payload.rows.size(); ++row) {
      const auto at = reinterpret_cast<const std::byte*>(payload.bytes[row]) - body.data();
      for (int k = 0; k < payload.rows[row].end - payload.rows[row].first; ++k)
        body[std::size_t(at + k)] &= ~std::byte{cells_visible};
    }
  }

  /// `drawn_samples`: in the picture that is drawn. On a machine, blocks are copied and placed in the first
  /// frame only.
  double cost_of(const EncodedStep& encoded, const PaintWork& work, double drawn_samples) const {
    const EncodedPart& sent = encoded.parts.front();
    const double blocks = double(encoded.counts.blocks), items = double(sent.items);
    if (setup_.machine) {
      const Machine& m = *setup_.machine;
      const double moved = placed_ ? 0 : items;
      return selecting_seconds(m, blocks, moved) +
             (sent.payload.empty() ? 0 : placing_seconds(m, double(work.blocks), moved)) +
             painting_seconds(m, double(work.samples));
    }
    constexpr double block = CellRanges::side * CellRanges::side;
    const WorkCosts& costs = usual_sheet_costs;
    return costs.pixel * drawn_samples + block * (costs.voxel * items + costs.hollow * blocks) +
           costs.payload;
  }

  SectionSetup setup_;
  Axis axis_;
  Grid whole_;
  VoxelBox box_;  ///< of what is read
  SliceStore store_;
  SliceBlocks blocks_;
  KeptBlocks kept_{0, 1, 1, std::numeric_limits<std::int64_t>::max()};
  ThreadTeam threads_;
  std::unique_ptr<FramePainter<SheetFrame>> painter_;
  bool placed_ = false;
};

}  // namespace

std::unique_ptr<SectionPainter> make_sheet_section(const SectionSetup& setup, Axis axis, double low,
                                                   double high) {
  return std::make_unique<SheetSection>(setup, axis, low, high);
}

}  // namespace ringsplat::sort_last
