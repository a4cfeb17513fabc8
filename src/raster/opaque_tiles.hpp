#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/byte_stream.hpp"
#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// Which tiles of a region are opaque: squares of 16 × 16 pixels from the region's corner on, of which those
/// at its right and lower edge may be smaller. In the course of a frame tiles become opaque and stay so.
class OpaqueTiles {
 public:
  static constexpr int tile_size = 16;  ///< pixels
  enum class Cover { none, some, all };

  OpaqueTiles() = default;
  OpaqueTiles(int width, int height)
      : columns_((width + tile_size - 1) / tile_size),
        rows_((height + tile_size - 1) / tile_size),
        opaque_(std::size_t(columns_) * std::size_t(rows_), 0) {
    sum_up();
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int opaque() const { return count_; }  ///< number of opaque tiles
  /// False while so few tiles are opaque that asking about every splat takes longer than drawing what they
  /// hide.
  bool worth_asking() const { return count_ > 0 && 8 * count_ >= columns_ * rows_; }
  bool is_opaque(int column, int row) const { return opaque_[at(column, row)] != 0; }
  /// By tile, row by row: 1 when it is opaque.
  std::span<const std::uint8_t> flags() const { return opaque_; }
  /// Call sum_up() after the last one, before windows are asked for.
  void set_opaque(int column, int row) {
    count_ += opaque_[at(column, row)] == 0;
    opaque_[at(column, row)] = 1;
  }
  void clear() {
    std::fill(opaque_.begin(), opaque_.end(), std::uint8_t{0});
    count_ = 0;
    sum_up();
  }

  /// Counts the opaque tiles above and to the left of every tile's corner (summed areas, Crow 1984).
  void sum_up() {
    sums_.assign(stride() * (std::size_t(rows_) + 1), 0);
    for (int row = 0; row < rows_; ++row) {
      std::int32_t* sum = sums_.data() + (std::size_t(row) + 1) * stride();
      std::int32_t in_row = 0;
      for (int column = 0; column < columns_; ++column) {
        in_row += is_opaque(column, row);
        sum[column + 1] = sum[std::ptrdiff_t(column) + 1 - std::ptrdiff_t(stride())] + in_row;
      }
    }
  }
  /// How many of the region's tiles under pixels x0 … x1, y0 … y1 are opaque, in four look-ups. Pixels count
  /// from the region's corner, x0 ≤ x1 and y0 ≤ y1; none when they are wholly outside.
  Cover cover(double x0, double y0, double x1, double y1) const {
    const int width = columns_ * tile_size, height = rows_ * tile_size;
    if (!(x1 >= 0 && y1 >= 0 && x0 < width && y0 < height)) return Cover::none;
    const std::size_t left = tile(x0, width), right = tile(x1, width) + 1, top = tile(y0, height),
                      bottom = tile(y1, height) + 1;
    const std::int32_t count = sums_[bottom * stride() + right] - sums_[top * stride() + right] -
                               sums_[bottom * stride() + left] + sums_[top * stride() + left];
    if (count == 0) return Cover::none;
    return std::size_t(count) == (right - left) * (bottom - top) ? Cover::all : Cover::some;
  }
  /// Whether opaque tiles hide all of these pixels that lie inside the region.
  bool hides(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1) const {
    return cover(double(x0), double(y0), double(x1), double(y1)) == Cover::all;
  }

 private:
  std::size_t stride() const { return std::size_t(columns_) + 1; }
  std::size_t at(int column, int row) const {
    return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
  }
  static std::size_t tile(double pixel, int size) {
    return std::size_t(static_cast<std::int32_t>(std::clamp(pixel, 0.0, double(size) - 1))) / tile_size;
  }

  int columns_ = 0, rows_ = 0, count_ = 0;
  std::vector<std::uint8_t> opaque_;
  std::vector<std::int32_t> sums_;
};

/// Of one region's opaque tiles, as they travel.
inline std::size_t bitmap_bytes(const OpaqueTiles& tiles) { return (tiles.flags().size() + 7) / 8; }

/// Appends one region's opaque tiles as they travel: the region's number, then a bit for each tile, row by
/// row.
inline void append_opaque_news(int region, const OpaqueTiles& tiles, Bytes& news) {
  append(news, std::int32_t{region});
  const std::size_t at = news.size();
  news.resize(at + bitmap_bytes(tiles), std::byte{0});
  for (std::size_t tile = 0; tile < tiles.flags().size(); ++tile)
    news[at + tile / 8] |= std::byte(tiles.flags()[tile] << (tile % 8));
}

/// Adds the news of any number of regions to `known`, which is indexed by region. Throws RunError when the
/// bytes name no region or end too early.
inline void read_opaque_news(std::span<const std::byte> news, std::vector<OpaqueTiles>& known) {
  std::size_t at = 0;
  while (at < news.size()) {
    std::int32_t region = -1;
    if (!take(news, at, region) || region < 0 || std::size_t(region) >= known.size() ||
        news.size() - at < bitmap_bytes(known[std::size_t(region)]))
      throw OtherBuild(fmt::format("news of opaque tiles are not understood at byte {}", at));
    OpaqueTiles& tiles = known[std::size_t(region)];
    for (int tile = 0; tile < tiles.columns() * tiles.rows(); ++tile)
      if ((std::to_integer<unsigned>(news[at + std::size_t(tile / 8)]) >> (tile % 8) & 1U) != 0)
        tiles.set_opaque(tile % tiles.columns(), tile / tiles.columns());
    tiles.sum_up();
    at += bitmap_bytes(tiles);
  }
}

}  // namespace ringsplat
