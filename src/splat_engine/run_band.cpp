#include <algorithm>
#include <bit>

#include "base/bit_runs.hpp"
#include "base/byte_stream.hpp"
#include "splat/voxel_run.hpp"
#include "splat_engine/row_band.hpp"

namespace ringsplat {
namespace {

/// Mask of the block's voxels that lie in these columns.
std::uint64_t in_columns(const VisibleBlock& block, Columns columns) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  constexpr std::uint32_t width = 64;
  const std::uint32_t from = columns.first > block.first ? columns.first - block.first : 0,
                      behind = columns.end < block.first + width ? block.first + width - columns.end : 0;
  return from < width && behind < width ? block.mask & all << from & all >> behind : 0;
}

/// Encodes runs of voxels without positions: the Renderer computes these from the view.
class RunBand final : public RowBand {
 public:
  explicit RunBand(const EncoderFrame& frame) : RowBand(frame), parts_(frame.rects.size()) {}

 private:
  /// Not zeroed when it grows, since all of it is written right after.
  template <class T>
  using Buffer = std::vector<T, UninitialisedAllocator<T>>;
  struct Part {
    Buffer<VoxelRun> blocks;
    Buffer<PackedVoxel> voxels;
  };

  /// Voxels of one of the row's blocks that go to a region.
  struct Piece {
    int region;
    std::size_t block;
    std::uint64_t mask;
  };

  void encode_row(int row) override {
    const VisibleBlock &front = found_.blocks.front(), &back = found_.blocks.back();
    const Columns all{front.first + std::uint32_t(std::countr_zero(front.mask)),
                      back.first + std::uint32_t(std::bit_width(back.mask))};
    const PixelWindow window = hull(window_of(all.first), window_of(all.end - 1));
    const PixelRect touched = frame_.geometry.regions.touched(window);
    const int region = touched.y0 * frame_.geometry.regions.columns() + touched.x0;
    if (touched.width() == 1 && touched.height() == 1 && hidden(region, window) == OpaqueTiles::Cover::none)
      return append_row(region, row);
    find_pieces(touched, all);
    if (pieces_.empty()) return;
    const auto samples = make_samples();
    packed_.resize(samples.size());
    pack(&samples.front().r, samples.size(), packed_.data());
    for (const Piece& piece : pieces_) append(piece, row);
  }

  /// Appends all the row's voxels to the region's part.
  void append_row(int region, int row) {
    const auto samples = make_samples();
    Part& part = parts_[std::size_t(region)];
    const std::size_t at = part.voxels.size();
    part.voxels.resize(at + samples.size());
    pack(&samples.front().r, samples.size(), part.voxels.data() + at);
    for (const VisibleBlock& block : found_.blocks) {
      part.blocks.push_back({std::uint32_t(row), block.first, block.mask});
      count(region, int(block.first), block.mask);
    }
  }

  void find_pieces(const PixelRect& touched, Columns all) {
    pieces_.clear();
    for (int y = touched.y0; y < touched.y1; ++y) {
      const int first_region = y * frame_.geometry.regions.columns();
      const PixelRect& pixels = rect(first_region);
      const Columns columns = reaching(1, pixels.y0, pixels.y1, all);
      if (columns.empty()) continue;
      for (int x = touched.x0; x < touched.x1; ++x) find_pieces_of(first_region + x, columns);
    }
  }

  /// Finds the row's visible voxels whose windows can meet the region. The painter clips any extra voxel.
  void find_pieces_of(int region, Columns columns) {
    const PixelRect& pixels = rect(region);
    columns = reaching(0, pixels.x0, pixels.x1, columns);
    if (columns.empty()) return;
    OpaqueTiles::Cover hidden = OpaqueTiles::Cover::none;
    if (opaque(region).worth_asking()) hidden = cover_of(region, columns.first, columns.end - 1);
    if (hidden == OpaqueTiles::Cover::all) return;
    for (std::size_t k = 0; k < found_.blocks.size(); ++k) {
      const VisibleBlock& block = found_.blocks[k];
      std::uint64_t mask = in_columns(block, columns);
      if (hidden == OpaqueTiles::Cover::some) mask = seen_of(region, block.first, mask);
      if (mask != 0) pieces_.push_back({region, k, mask});
    }
  }

  /// How much of the window of the voxels in columns first … last is opaque; wider by a rounding error.
  OpaqueTiles::Cover cover_of(int region, std::uint32_t first, std::uint32_t last) const {
    constexpr double rounding = 1e-6;
    const PixelRect& pixels = rect(region);
    const double x = dda_.row_start().x - pixels.x0 - 0.5, y = dda_.row_start().y - pixels.y0 - 0.5;
    const double xa = x + dda_.steps_x()[first], xb = x + dda_.steps_x()[last];
    const double ya = y + dda_.steps_y()[first], yb = y + dda_.steps_y()[last];
    const double before_x = double(frame_.reach.x) + rounding, before_y = double(frame_.reach.y) + rounding;
    return opaque(region).cover(std::min(xa, xb) - before_x, std::min(ya, yb) - before_y,
                                std::max(xa, xb) + before_x + 1, std::max(ya, yb) + before_y + 1);
  }

  /// Those voxels of `mask` (bit k: column first + k) that are not hidden.
  std::uint64_t seen_of(int region, std::uint32_t first, std::uint64_t mask) const {
    std::uint64_t seen = 0;
    for_each_bit_run(mask,
                     [&](int begin, int count) { seen |= seen_of_run(region, first, begin, begin + count); });
    return seen;
  }
  /// The same for the run of bits begin … end − 1. Halves a run that is partly hidden.
  std::uint64_t seen_of_run(int region, std::uint32_t first, int begin, int end) const {
    const OpaqueTiles::Cover hidden =
        cover_of(region, first + std::uint32_t(begin), first + std::uint32_t(end - 1));
    if (hidden == OpaqueTiles::Cover::all) return 0;
    if (hidden == OpaqueTiles::Cover::none || end - begin == 1)
      return ~std::uint64_t{0} >> (64 - (end - begin)) << begin;
    const int middle = begin + (end - begin) / 2;
    return seen_of_run(region, first, begin, middle) | seen_of_run(region, first, middle, end);
  }

  /// Gives a piece's packed voxels to its region's part.
  void append(const Piece& piece, int row) {
    const VisibleBlock& block = found_.blocks[piece.block];
    Part& part = parts_[std::size_t(piece.region)];
    part.blocks.push_back({std::uint32_t(row), block.first, piece.mask});
    count(piece.region, int(block.first), piece.mask);
    for (std::uint64_t mask = piece.mask; mask != 0;) {
      const int begin = std::countr_zero(mask);
      // Transparent voxels between two visible ones do not split a copy: samples are packed.
      const std::uint64_t gone = block.mask & ~mask & ~std::uint64_t{0} << begin;
      const std::uint64_t here = gone == 0 ? mask : mask & ((std::uint64_t{1} << std::countr_zero(gone)) - 1);
      const auto before = std::popcount(block.mask & ((std::uint64_t{1} << begin) - 1));
      const PackedVoxel* const first = packed_.data() + block.sample + before;
      part.voxels.insert(part.voxels.end(), first, first + std::popcount(here));
      mask &= ~here;
    }
  }

  void append_parts(int region, std::span<const std::unique_ptr<RowBand>> bands, Bytes& payload) override {
    const auto part_of = [region](const std::unique_ptr<RowBand>& band) -> Part& {
      return static_cast<RunBand&>(*band).parts_[std::size_t(region)];
    };
    BlockGroup group{region, 0, 0};
    for (const auto& band : bands) {
      group.blocks += std::uint32_t(part_of(band).blocks.size());
      group.voxels += std::uint32_t(part_of(band).voxels.size());
    }
    ringsplat::append(payload, group);
    for (const auto& band : bands) move_values(part_of(band).blocks, payload);
    for (const auto& band : bands) move_values(part_of(band).voxels, payload);
  }

  static void move_values(auto& values, Bytes& payload) {
    const auto raw = std::as_bytes(std::span(values));
    const std::size_t at = payload.size();
    payload.resize(at + raw.size());
    std::copy(raw.begin(), raw.end(), payload.begin() + std::ptrdiff_t(at));
    values.clear();
  }

  std::vector<Part> parts_;     ///< by region
  std::vector<Piece> pieces_;   ///< of the row, region by region
  Buffer<PackedVoxel> packed_;  ///< the row's voxels
};

}  // namespace

std::unique_ptr<RowBand> make_run_band(const EncoderFrame& frame) { return std::make_unique<RunBand>(frame); }

}  // namespace ringsplat
