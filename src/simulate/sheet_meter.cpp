#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "sheet_engine/block_windows.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/transparent_values.hpp"
#include "sheet_engine/visible_tiles.hpp"
#include "simulate/meter.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

/// Counts the samples that a slice's visible blocks take each Renderer, as SheetPainter does when it paints
/// them: the pixels of the tiles that they touch, for every slab that begins at the slice.
class SampleCounter {
 public:
  /// `finer`: as of BlockWindows.
  explicit SampleCounter(const SheetFrame& frame, int finer = 1)
      : frame_(frame), windows_(frame.geometry, finer) {
    for (int region = 0; region < frame.geometry.regions.count(); ++region)
      if (renderer_of(region) != FramePlan::nobody) drawn_.push_back(region);
    for (VisibleTiles* tiles : {&before_, &behind_}) tiles->lay_out(frame.geometry.regions, drawn_);
  }

  /// Begins the slice of a step.
  void begin(int step) {
    step_ = step;
    for (VisibleTiles* tiles : {&before_, &behind_}) {
      tiles->clear();
      tiles->add_slab();
    }
  }
  /// Adds a block with visible cells.
  void add(int column, int row) {
    const int slice = frame_.geometry.slice_at(step_);
    const auto mark = [&](VisibleTiles& tiles, const BlockWindows& windows) {
      tiles.mark(frame_.geometry.in_layer(windows.of(column, row, slice), frame_.geometry.layer_of(slice)));
    };
    if (step_ == 0) mark(before_, windows_.before_first);
    mark(behind_, windows_.behind(step_));
  }
  /// By Renderer.
  std::vector<std::uint64_t> samples(std::size_t renderers) const {
    std::vector<std::uint64_t> samples(renderers, 0);
    for (const VisibleTiles* tiles : {&before_, &behind_})
      for (std::size_t g = 0; g < tiles->groups().size(); ++g)
        samples[std::size_t(renderer_of(drawn_[tiles->groups()[g].slot]))] +=
            std::uint64_t(std::popcount(*tiles->masks_of(g)) * tile_side * tile_side);
    return samples;
  }

 private:
  int renderer_of(int region) const { return frame_.drawers[std::size_t(region)]; }

  const SheetFrame& frame_;
  SlabWindows windows_;
  std::vector<int> drawn_;  ///< regions
  int step_ = 0;
  VisibleTiles before_, behind_;  ///< of the slab before the first slice, and of that behind this one
};

/// Counts what a SheetEncoder would send of slices that have `finer` times as many voxels along each side.
/// What is between this slice's voxels is linear, and the slices beside it are alike.
class WeighedEncoder final : public FrameEncoder<SheetFrame> {
 public:
  WeighedEncoder(std::shared_ptr<const SheetFrame> frame, int renderers, const SliceStore& store,
                 double voxel_weight)
      : FrameEncoder(std::move(frame), store),
        finer_(std::max(1, int(std::lround(std::sqrt(voxel_weight))))),
        windows_(geometry(), frame_->reach(), frame_->reach(), frame_->reach(), finer_),
        samples_(*frame_, finer_),
        parts_(std::size_t(renderers)),
        tile_marked_(std::size_t(geometry().regions.count())) {}

  std::vector<int> shown() override {
    std::vector<int> steps(std::size_t(geometry().slices));
    std::iota(steps.begin(), steps.end(), 0);
    return steps;
  }
  void begin(int step) override {
    slice_ = slice(step);
    columns_ = CellRanges::blocks_along(slice_.width * finer_);
    rows_ = CellRanges::blocks_along(slice_.height * finer_);
    counts_ = {.voxels = std::uint64_t(slice_.width) * std::uint64_t(slice_.height)};
    counts_.blocks = std::uint64_t(columns_) * std::uint64_t(rows_);
    seen_blocks_ = 0;
    samples_.begin(step);
    std::fill(parts_.begin(), parts_.end(), Part{});
    std::fill(tile_marked_.begin(), tile_marked_.end(), false);
    visible_.assign(std::size_t(counts_.blocks), false);
    visit_type(slice_.type, [&](auto zero) { find_visible<decltype(zero)>(); });
    next_row_ = 0;
  }

  bool work() override {
    const int end = std::min(rows_, next_row_ + std::max(1, 1024 / columns_));
    for (; next_row_ < end; ++next_row_)
      for (int column = 0; column < columns_; ++column)
        if (needed(column, next_row_)) deal(column, next_row_);
    return next_row_ == rows_;
  }

  EncodedStep finish() override {
    EncodedStep step;
    step.parts.resize(parts_.size());
    step.counts = counts_;
    constexpr std::uint64_t voxels = CellRanges::side * CellRanges::side;
    step.counts.visible = std::min(counts_.voxels, seen_blocks_ * voxels / std::uint64_t(finer_ * finer_));
    const auto samples = samples_.samples(parts_.size());
    for (std::size_t r = 0; r < parts_.size(); ++r)
      if (parts_[r].present > 0) write(parts_[r], samples[r], step.parts[r]);
    for (std::size_t region = 0; region < tile_marked_.size(); ++region)
      if (tile_marked_[region]) step.parts[std::size_t(drawer_of(int(region)))].tiles.push_back(int(region));
    return step;
  }

  void take_news(std::span<const std::byte>) override {}

 private:
  /// The blocks for one Renderer, as many as come.
  struct Part {
    std::int64_t last = -1;  ///< the last one's number
    int first_row = -1, last_row = -1, first_in_row = 0, last_in_row = 0;
    std::uint64_t present = 0, bytes = 0;  ///< of its rows before the last
    std::uint64_t all_bytes() const { return bytes + (present > 0 ? in_row() : 0); }
    std::uint64_t in_row() const { return std::uint64_t(last_in_row - first_in_row + 1); }
  };

  bool at(int column, int row) const {
    return visible_[std::size_t(row) * std::size_t(columns_) + std::size_t(column)];
  }

  template <class T>
  void find_visible() {
    // The slice's voxels on either side of each block's ends.
    const auto ends = [this](int block, int voxels) {
      constexpr double side = CellRanges::side;
      const double from = block * side / finer_ - 0.5,
                   to = std::min((block + 1) * side / finer_ - 0.5, voxels - 0.5);
      return std::pair(std::clamp(int(std::floor(from)), 0, voxels - 1),
                       std::clamp(int(std::ceil(to)), 0, voxels - 1));
    };
    for (int row = 0; row < rows_; ++row) {
      const auto [y0, y1] = ends(row, slice_.height);
      for (int column = 0; column < columns_; ++column) {
        const auto [x0, x1] = ends(column, slice_.width);
        double low = INFINITY, high = -INFINITY;
        for (int y = y0; y <= y1; ++y)
          for (int x = x0; x <= x1; ++x) {
            T value;
            std::memcpy(&value, slice_.values_of_row(y) + std::size_t(x) * sizeof(T), sizeof(T));
            low = std::min(low, double(value));
            high = std::max(high, double(value));
          }
        visible_[std::size_t(row) * std::size_t(columns_) + std::size_t(column)] =
            low <= high && frame_->transparent.holding(low, high) == TransparentValues::nowhere;
      }
    }
  }

  /// Whether interpolation or gradients in visible cells use the block's voxels.
  bool needed(int column, int row) const {
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y)
      for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x)
        if (at(x, y)) return true;
    return false;
  }

  void deal(int column, int row) {
    const PixelWindow window = windows_.of(column, row, slice_.index);
    const Regions& regions = geometry().regions;
    const PixelRect touched = regions.touched(window);
    if (at(column, row)) samples_.add(column, row);
    if (!touched.empty()) ++seen_blocks_;
    const std::int64_t number = std::int64_t{row} * columns_ + column;
    for (int y = touched.y0; y < touched.y1; ++y)
      for (int x = touched.x0; x < touched.x1; ++x) {
        const int region = y * regions.columns() + x, renderer = drawer_of(region);
        if (renderer == FramePlan::nobody) continue;
        tile_marked_[std::size_t(region)] = true;
        Part& part = parts_[std::size_t(renderer)];
        if (part.last == number) continue;
        part.last = number;
        if (part.last_row != row) {
          part.bytes = part.all_bytes();
          part.first_in_row = column;
        }
        if (part.first_row < 0) part.first_row = row;
        part.last_row = row;
        part.last_in_row = column;
        ++part.present;
      }
  }

  void write(const Part& part, std::uint64_t samples, EncodedPart& out) const {
    constexpr std::uint64_t voxels = CellRanges::side * CellRanges::side;
    const auto rows = std::uint64_t(part.last_row - part.first_row + 1);
    const std::uint64_t bytes = sizeof(SheetHeader) + rows * sizeof(BlockRow) + part.all_bytes() +
                                part.present * voxels * size_of(slice_.type);
    out.payload = measured_payload({bytes, {part.all_bytes(), samples}});
    out.items = std::uint32_t(part.present);
    out.passes = 1;
  }

  int finer_;
  BlockWindows windows_;
  SampleCounter samples_;
  SliceView slice_;
  int columns_ = 1, rows_ = 1, next_row_ = 0;  ///< of blocks
  std::vector<bool> visible_;                  ///< by block
  std::uint64_t seen_blocks_ = 0;
  EncodeCounts counts_;
  std::vector<Part> parts_;        ///< by Renderer
  std::vector<bool> tile_marked_;  ///< by region
};

}  // namespace

Meter make_sheet_meter(std::shared_ptr<const SheetFrame> frame) {
  return [frame, counter = SampleCounter(*frame)](int step, const std::vector<EncodedPart>& parts) mutable {
    const Grid& grid = frame->geometry.grid;
    const Axis axis = frame->geometry.traversal.axis;
    std::vector<PaintWork> work(parts.size());
    counter.begin(step);
    for (std::size_t r = 0; r < parts.size(); ++r) {
      if (parts[r].payload.empty()) continue;
      const auto body = std::span<const std::byte>(parts[r].payload).subspan(sizeof(Header));
      read_sheet_payload(body, grid.slice_width(axis), grid.slice_height(axis), grid.type)
          .for_each_block([&](int column, int row, std::uint8_t byte) {
            ++work[r].blocks;
            if ((byte & cells_visible) != 0) counter.add(column, row);
          });
    }
    const auto samples = counter.samples(parts.size());
    for (std::size_t r = 0; r < parts.size(); ++r) work[r].samples = samples[r];
    return work;
  };
}

std::unique_ptr<Encoder> make_weighed_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                              const SliceStore& store, double voxel_weight) {
  return std::make_unique<WeighedEncoder>(std::move(frame), renderers, store, voxel_weight);
}

}  // namespace ringsplat
