#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tuple>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "raster/opaque_tiles.hpp"
#include "ringsplat/base/error.hpp"
#include "sheet_engine/block_windows.hpp"
#include "sheet_engine/kept_blocks.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

constexpr int side = CellRanges::side;

/// Sends each Renderer the blocks of a slice that its pixels can show. Blocks and their voxels are copied as
/// they are; all else is the Renderer's work.
class SheetEncoder final : public FrameEncoder<SheetFrame> {
 public:
  SheetEncoder(std::shared_ptr<const SheetFrame> frame, int renderers, const SliceStore& store,
               SliceBlocks& blocks, bool skip_empty, KeptBlocks* kept)
      : FrameEncoder(std::move(frame), store),
        blocks_(blocks),
        skip_empty_(skip_empty),
        windows_(geometry(), frame_->reach(), frame_->reach(), frame_->reach()),
        parts_(std::size_t(renderers)) {
    if (!store_.knows_cell_ranges(axis()))
      throw RunError(
          fmt::format(
              "frame {} is drawn by sheets, but the ranges of the cells between slices were not loaded",
              frame_->number),
          "load the volume for all the frames that are to be drawn, of both engines");
    if (frame_->tinted() && whole_store_.labels() != nullptr)
      labels_of_level_ = &whole_store_.labels()->level(frame_->shown.reduction.factor);
    const Regions& regions = geometry().regions;
    for (int region = 0; region < regions.count(); ++region) {
      const PixelRect rect = regions.rect(region);
      opaque_.emplace_back(rect.width(), rect.height());
    }
    tile_marked_.resize(std::size_t(regions.count()));
    // Of all the whole volume's slices, other GPs' too, so that a clip box changes no table.
    for (const SliceRange& range : store_.ranges(axis())) {
      low_ = std::min(low_, range.low);
      high_ = std::max(high_, range.high);
    }
    if (kept != nullptr) kept_ = kept->begin_frame(*frame_, value_scale(*frame_, low_, high_));
  }

  std::vector<int> shown() override {
    std::vector<bool> may_show(std::size_t(geometry().slices), true);
    if (skip_empty_ && !labels_show_alone())
      may_show = shown_slices(store_, geometry().box, axis(), frame_->reach(), frame_->transparent);
    std::vector<int> steps;
    for (int step = 0; step < geometry().slices; ++step)
      if (may_show[std::size_t(geometry().slice_at(step))]) steps.push_back(step);
    return steps;
  }

  void begin(int step) override {
    slice_ = slice(step);
    if (labels_of_level_ != nullptr)
      labels_ = labels_of_level_->slice(axis(), geometry().slice_at(step), geometry().box);
    columns_ = CellRanges::blocks_along(slice_.width);
    const auto layer_of = [this](int at) {
      return geometry().layer_of(geometry().slice_at(std::clamp(at, 0, geometry().slices - 1)));
    };
    // Of slabs at the slice, and for gradients beside it.
    std::tie(first_layer_, last_layer_) =
        std::minmax(layer_of(step - frame_->reach()), layer_of(step + frame_->reach() - 1));
    states_ = blocks_.of(store_, geometry().box, axis(), slice_.index, frame_->reach(), frame_->transparent);
    counts_ = {.voxels = std::uint64_t(slice_.width) * std::uint64_t(slice_.height),
               .blocks = states_.size()};
    next_row_ = 0;
    elsewhere_ = byte_elsewhere();
    for (std::size_t r = 0; r < parts_.size(); ++r) {
      parts_[r].begin();
      if (kept_.shelf) parts_[r].held = &kept_.shelf->held(slice_.index, int(r));
    }
    std::fill(tile_marked_.begin(), tile_marked_.end(), false);
  }

  bool work() override {
    const int rows = int(states_.size()) / columns_, row_of_pieces = std::max(1, 1024 / columns_);
    const int end = std::min(rows, next_row_ + row_of_pieces);
    for (; next_row_ < end; ++next_row_)
      for (int column = 0; column < columns_; ++column) deal(column, next_row_);
    return next_row_ == rows;
  }

  EncodedStep finish() override {
    EncodedStep step;
    step.parts.resize(parts_.size());
    step.counts = counts_;
    for (std::size_t r = 0; r < parts_.size(); ++r)
      if (parts_[r].present > 0) {
        const std::uint16_t plane = kept_.shelf ? kept_.shelf->plane_of(slice_.index) : no_plane;
        write(parts_[r], plane, step.parts[r]);
        if (plane != no_plane) parts_[r].keep();
      }
    for (std::size_t region = 0; region < tile_marked_.size(); ++region)
      if (tile_marked_[region])
        step.parts[std::size_t(drawer_of(int(region)))].tiles.push_back(static_cast<int>(region));
    return step;
  }

  void take_news(std::span<const std::byte> news) override {
    if (!news.empty()) read_opaque_news(news, opaque_);
  }

 private:
  /// What one Renderer is told of a block, by its byte in the payload.
  struct Said {
    std::uint32_t block;
    std::uint8_t byte;
  };
  /// The blocks for one Renderer.
  struct Part {
    std::vector<Said> said;  ///< ascending
    std::uint32_t present = 0, kept = 0;
    std::size_t bytes = 0;              ///< of voxels that are sent
    std::vector<bool>* held = nullptr;  ///< by block: whether the Renderer keeps its voxels
    void begin() {
      said.clear();
      present = kept = 0;
      bytes = 0;
    }
    bool knows(std::uint32_t block) const { return !said.empty() && said.back().block == block; }
    bool holds(std::uint32_t block) const { return held != nullptr && (*held)[block]; }
    void keep() {
      for (const Said& one : said)
        if (one.byte >= block_present) (*held)[one.block] = true;
    }
  };

  int block_width(int column) const { return std::min(side, slice_.width - column * side); }
  int block_height(int row) const { return std::min(side, slice_.height - row * side); }
  std::uint64_t voxels_of(int column, int row) const {
    return std::uint64_t(block_width(column)) * std::uint64_t(block_height(row));
  }

  /// Whether the cells behind a block can be visible.
  bool sees(const BlockState& state) const {
    return geometry().traversal.ascending ? state.visible_above : state.visible_below;
  }

  /// Whether all that a block is used for lies behind a clip plane.
  bool cut_off(int column, int row) const {
    const auto [u, v] = in_plane(axis());
    // A slab that is cut takes the values at its ends, up to a voxel beside what is left of it, or in
    // perspective as far as its slope says.
    glm::dvec3 middle(slice_.index), around(frame_->reach() + 1);
    middle[u] = side * column + 0.5 * (block_width(column) - 1);
    middle[v] = side * row + 0.5 * (block_height(row) - 1);
    if (const auto& eye = geometry().view.eye) {
      const glm::dvec3 ray = middle - *eye;
      around += glm::abs(ray / ray[int(axis())]);
    }
    around[u] += 0.5 * block_width(column);
    around[v] += 0.5 * block_height(row);
    return std::ranges::any_of(geometry().clip_planes, [&](const LatticePlane& plane) {
      return plane.before(middle) + glm::dot(glm::abs(plane.normal), around) < 0;
    });
  }

  /// Finds the Renderers of a block that is needed, or is not as most others are.
  void deal(int column, int row) {
    const auto block = std::uint32_t(row * columns_ + column);
    const BlockState& state = states_[block];
    const bool needed = state.needed || (labels_show_alone() && has_labels(column, row));
    if (!needed && state.transparent == elsewhere_) return;
    if (!geometry().clip_planes.empty() && cut_off(column, row)) return;
    const PixelWindow seen = windows_.of(column, row, slice_.index);
    bool outside = true;
    for (int layer = first_layer_; layer <= last_layer_; ++layer) {
      const PixelWindow window = geometry().in_layer(seen, layer);
      const PixelRect touched = geometry().regions.touched(window);
      outside = touched.empty();
      if (needed)
        send(block, column, row, window, touched);
      else
        for_each_region(touched, [&](int, Part& part) {
          if (!part.knows(block)) part.said.push_back({block, state.transparent});
        });
    }
    if (needed) (outside ? counts_.outside : counts_.visible) += voxels_of(column, row);
  }

  void send(std::uint32_t block, int column, int row, const PixelWindow& window, const PixelRect& touched) {
    const bool seen = sees(states_[block]);
    const std::uint8_t labelled = has_labels(column, row) ? block_labelled : 0;
    const std::size_t bytes = voxels_of(column, row) * (size_of(slice_.type) + (labelled != 0 ? 1 : 0));
    for_each_region(touched, [&](int region, Part& part) {
      if (hidden(region, window)) return;
      tile_marked_[std::size_t(region)] = true;
      if (part.knows(block)) return;
      const bool kept = part.holds(block);
      part.said.push_back(
          {block, std::uint8_t(block_present | (seen ? cells_visible : 0) | (kept ? block_kept : labelled))});
      ++part.present;
      if (kept)
        ++part.kept;
      else
        part.bytes += bytes;
    });
  }

  /// Whether labels show where values do not: single slices are seen all over.
  bool labels_show_alone() const { return labels_of_level_ != nullptr && !frame_->composites(); }

  /// Whether a segmentation covers some of a block.
  bool has_labels(int column, int row) const {
    bool some = false;
    for (int y = 0; y < block_height(row) && labels_of_level_ != nullptr && !some; ++y) {
      const std::byte* from = labels_.values_of_row(row * side + y) + column * side;
      some =
          std::any_of(from, from + block_width(column), [](std::byte label) { return label != std::byte{}; });
    }
    return some;
  }

  /// Calls `visit(region, part)` for each region in columns and rows of them that somebody draws.
  template <class Visit>
  void for_each_region(const PixelRect& block, Visit&& visit) {
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x) {
        const int region = y * geometry().regions.columns() + x, renderer = drawer_of(region);
        if (renderer != FramePlan::nobody) visit(region, parts_[std::size_t(renderer)]);
      }
  }

  bool hidden(int region, const PixelWindow& window) const {
    const OpaqueTiles& tiles = opaque_[std::size_t(region)];
    if (tiles.opaque() == 0) return false;
    const PixelRect rect = geometry().regions.rect(region);
    return tiles.hides(window.x0 - rect.x0, window.y0 - rect.y0, window.x1 - rect.x0, window.y1 - rect.y0);
  }

  /// The byte of most blocks that nobody needs.
  std::uint8_t byte_elsewhere() const {
    std::array<std::size_t, BlockState::not_a_number + 1> blocks{};
    for (const BlockState& state : states_)
      if (!state.needed) ++blocks[state.transparent];
    return std::uint8_t(std::max_element(blocks.begin(), blocks.end()) - blocks.begin());
  }

  void write(const Part& part, std::uint16_t plane, EncodedPart& out) const {
    const auto row_of = [this](const Said& said) { return int(said.block) / columns_; };
    const int first = row_of(part.said.front()), rows = row_of(part.said.back()) + 1 - first;
    SheetHeader header;
    header.low = low_;
    header.high = high_;
    header.present = part.present;
    header.elsewhere = elsewhere_;
    header.scalar = std::uint8_t(slice_.type);
    header.first_row = std::uint16_t(first);
    header.rows = std::uint16_t(rows);
    header.plane = plane;
    header.shelf = kept_.number;
    out.payload = Message::body_buffer();
    out.payload.reserve(out.payload.size() + sizeof header +
                        std::size_t(rows) * (sizeof(BlockRow) + std::size_t(columns_)) + part.bytes);
    append(out.payload, header);
    auto next = part.said.begin();
    for (int row = first; row < first + rows; ++row) {
      const auto begin = next;
      while (next != part.said.end() && row_of(*next) == row) ++next;
      append_row({begin, next}, out.payload);
    }
    const std::size_t before = out.payload.size();
    out.payload.resize(before + part.bytes);
    copy_voxels(part, out.payload.data() + before);
    out.items = part.present;
    out.kept = part.kept;
    out.passes = 1;
  }

  /// Appends what is said of a row's blocks, from the first to the last.
  void append_row(std::span<const Said> said, Bytes& payload) const {
    const auto column_of = [this](const Said& one) { return std::uint16_t(int(one.block) % columns_); };
    BlockRow row;
    if (!said.empty()) row = {column_of(said.front()), std::uint16_t(column_of(said.back()) + 1)};
    append(payload, row);
    auto next = said.begin();
    for (std::uint16_t column = row.first; column < row.end; ++column)
      append(payload, column == column_of(*next) ? (next++)->byte : elsewhere_);
  }

  /// Copies the voxels of the present blocks that the Renderer does not keep, and labels, to `to`.
  void copy_voxels(const Part& part, std::byte* to) const {
    for (const Said& said : part.said) {
      if (said.byte < block_present || (said.byte & block_kept) != 0) continue;
      const int column = int(said.block) % columns_, row = int(said.block) / columns_;
      to = copy_block(slice_, column, row, to);
      if ((said.byte & block_labelled) != 0) to = copy_block(labels_, column, row, to);
    }
  }

  /// Returns the end of the copy.
  std::byte* copy_block(const SliceView& slice, int column, int row, std::byte* to) const {
    const std::size_t scalar = size_of(slice.type), bytes = std::size_t(block_width(column)) * scalar;
    const std::byte* from = slice.values_of_row(row * side) + std::size_t(column * side) * scalar;
    for (int y = 0; y < block_height(row); ++y, from += slice.row_pitch() * scalar, to += bytes)
      std::memcpy(to, from, bytes);
    return to;
  }

  SliceBlocks& blocks_;
  bool skip_empty_;
  BlockWindows windows_;
  double low_ = INFINITY, high_ = -INFINITY;  ///< of the volume's values
  std::vector<OpaqueTiles> opaque_;           ///< by region, as far as news have come
  SliceView slice_, labels_;
  const SliceStore* labels_of_level_ = nullptr;  ///< null: there are none, or nothing is tinted by them
  int columns_ = 1;                              ///< of blocks
  std::span<const BlockState> states_;
  int next_row_ = 0;
  int first_layer_ = 0, last_layer_ = 0;  ///< that are drawn with the slice
  std::uint8_t elsewhere_ = 0;            ///< the byte of blocks of which nothing is said
  EncodeCounts counts_;
  std::vector<Part> parts_;        ///< by Renderer
  std::vector<bool> tile_marked_;  ///< by region: has a block of the slice
  KeptBlocks::OfFrame kept_;
};

}  // namespace

std::unique_ptr<Encoder> make_sheet_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                            const SliceStore& store, SliceBlocks& blocks, bool skip_empty,
                                            KeptBlocks* kept) {
  return std::make_unique<SheetEncoder>(std::move(frame), renderers, store, blocks, skip_empty, kept);
}

}  // namespace ringsplat
