#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "base/thread_team.hpp"
#include "engine_parts/frame_engine.hpp"
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
    placed_.resize(std::size_t(store_.grid().slices(axis)));
  }

  Drawn draw(const FrameSpec& spec, Image& picture) override {
    Drawn drawn;
    drawn.costs.resize(std::size_t(whole_.slices(axis_)));
    if (setup_.section.slices() < 1) return drawn;
    const auto frame = frame_of(spec);
    if (frame->geometry.traversal.axis != axis_)
      throw InputError("the view does not traverse the slices of which the sections are",
                       "use a smaller --turn");
    const auto part = part_of(*frame_of(counted(spec)), box_);
    const auto encoder =
        make_sheet_encoder(part, 1, store_, blocks_, false, setup_.machine ? nullptr : &kept_);
    const Meter meter = setup_.machine ? make_sheet_meter(part) : nullptr;
    if (!painter_) painter_ = make_sheet_painter(0, 1, threads_);
    painter_->begin_frame(frame);
    if (const auto& m = setup_.machine; m && setup_.first)
      drawn.seconds = m->gp.frame + m->renderer.frame + m->sheets.table;
    const auto [first, end] = own_steps(frame->geometry);
    for (int step = std::max(first - drawn_before, 0);
         step < std::min(end + drawn_behind, frame->geometry.slices); ++step)
      draw_step(step, step >= first && step < end, *frame, *part, *encoder, meter, drawn);
    while (painter_->conclude()) continue;
    finish(*painter_, frame->geometry.regions, setup_, picture, drawn);
    // Simulated ranks draw one after another, so that one of them only needs planes.
    if (setup_.machine) painter_.reset();
    charge(drawn.seconds);
    return drawn;
  }

  std::vector<double> region_costs(const FrameSpec& spec) {
    auto all = std::make_shared<SheetFrame>(*make_sheet_frame(spec, whole_, 1, 1));
    const int regions = all->geometry.regions.count();
    std::vector<double> costs(std::size_t(regions) + 1);
    all->geometry.dealt.resize(std::size_t(regions));
    std::iota(all->geometry.dealt.begin(), all->geometry.dealt.end(), 0);
    all->plan = plan_of(all->geometry, 1, regions);
    const auto part = part_of(*all, box_);
    const auto encoder = make_sheet_encoder(part, regions, store_, blocks_, false, nullptr);
    const Meter meter = make_sheet_meter(part);
    const auto [first, end] = own_steps(all->geometry);
    for (int step = first; step < end; ++step) {
      const int local_step = local_step_of(all->slice_at(step), *part);
      encoder->begin(local_step);
      while (!encoder->work()) continue;
      const EncodedStep encoded = encoder->finish();
      const auto work = meter(local_step, encoded.parts);
      // A block is seen in some two regions.
      for (std::size_t r = 0; r < work.size(); ++r)
        costs[r] += cost_of({}, 0, double(work[r].samples), 0.5 * double(encoded.parts[r].items));
      costs.back() += cost_of(encoded.counts, 1, 0, 0);
    }
    costs.back() *= double(end - first + drawn_before + drawn_behind) / double(std::max(end - first, 1));
    return costs;
  }

  std::uint64_t slice_memory() const override { return store_.allocated_bytes(); }

 private:
  std::shared_ptr<const SheetFrame> frame_of(const FrameSpec& spec) const {
    if (setup_.regions.slices() < 1) return make_sheet_frame(spec, whole_, 1, 1);
    auto frame = std::make_shared<SheetFrame>(*make_sheet_frame(spec, whole_, 1, 1));
    auto& dealt = frame->geometry.dealt;
    dealt.assign(std::size_t(frame->geometry.regions.count()), RegionOwners::nobody);
    std::fill(dealt.begin() + setup_.regions.first, dealt.begin() + setup_.regions.end, 0);
    frame->plan = plan_of(frame->geometry, 1, 1);
    return frame;
  }

  int local_slice(int slice) const { return slice - box_.first[static_cast<int>(axis_)]; }
  int local_step_of(int slice, const SheetFrame& part) const {
    return part.geometry.traversal.slice_at(local_slice(slice), part.geometry.slices);
  }

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
    const int slice = frame.slice_at(step), local_step = local_step_of(slice, part);
    encoder.begin(local_step);
    while (!encoder.work()) continue;
    EncodedStep encoded = encoder.finish();
    EncodedPart& sent = encoded.parts.front();
    if (!own && !sent.payload.empty()) hide_cells(sent.payload, part.geometry.grid);
    const PaintWork work = meter ? meter(local_step, encoded.parts).front() : PaintWork{};
    const double moved = setup_.machine ? newly_placed(sent.payload, part.geometry.grid, local_slice(slice))
                                        : double(sent.items);
    const std::uint64_t samples = painter_->counts().samples;
    if (!sent.payload.empty()) {
      painter_->begin({step, sent.passes, std::span<const std::byte>(sent.payload).subspan(sizeof(Header))});
      while (!painter_->work()) continue;
      while (painter_->prepare()) continue;
    }
    const double drawn_samples = double(painter_->counts().samples - samples);
    double cost = cost_of(encoded.counts, setup_.machine && sent.payload.empty() ? 0 : 1,
                          setup_.machine ? double(work.samples) : drawn_samples, moved);
    if (setup_.machine) cost += setup_.machine->sheets.look * double(work.blocks);
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

  /// Blocks of a slice that are drawn for the first time.
  double newly_placed(const Bytes& message, const Grid& grid, int slice) {
    if (message.empty()) return 0;
    const SheetPayload payload =
        read_sheet_payload(std::span<const std::byte>(message).subspan(sizeof(Header)),
                           grid.slice_width(axis_), grid.slice_height(axis_), grid.type);
    const int columns = CellRanges::blocks_along(grid.slice_width(axis_));
    std::vector<bool>& placed = placed_[std::size_t(slice)];
    placed.resize(std::size_t(columns * CellRanges::blocks_along(grid.slice_height(axis_))));
    double fresh = 0;
    for (std::size_t row = 0; row < payload.rows.size(); ++row)
      for (int column = payload.rows[row].first; column < payload.rows[row].end; ++column) {
        const int block = (payload.header.first_row + int(row)) * columns + column;
        if (payload.bytes[row][column - payload.rows[row].first] < block_present ||
            placed[std::size_t(block)])
          continue;
        placed[std::size_t(block)] = true;
        ++fresh;
      }
    return fresh;
  }

  /// Of a slice, but for the blocks that a Renderer is told of. `moved`: blocks that are copied and placed.
  double cost_of(const EncodeCounts& counts, double payloads, double samples, double moved) const {
    const auto blocks = double(counts.blocks);
    if (setup_.machine) {
      const Machine& m = *setup_.machine;
      return selecting_seconds(m, blocks, moved) + placing_seconds(m, 0, moved, payloads) +
             painting_seconds(m, samples);
    }
    constexpr double block = CellRanges::side * CellRanges::side;
    const WorkCosts& costs = usual_sheet_costs;
    return costs.pixel * samples + block * (costs.voxel * moved + costs.hollow * blocks) +
           costs.payload * payloads;
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
  std::vector<std::vector<bool>> placed_;  ///< by slice and block: whether it was drawn, on a machine
};

}  // namespace

std::unique_ptr<SectionPainter> make_sheet_section(const SectionSetup& setup, Axis axis, double low,
                                                   double high) {
  return std::make_unique<SheetSection>(setup, axis, low, high);
}

std::vector<double> region_costs(const SectionSetup& setup, Axis axis, double low, double high,
                                 const FrameSpec& spec) {
  return SheetSection(setup, axis, low, high).region_costs(spec);
}

}  // namespace ringsplat::sort_last
