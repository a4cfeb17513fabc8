#include "raster/opaque_tiles.hpp"

#include <fmt/format.h>

#include "base/byte_stream.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

std::size_t bitmap_bytes(const OpaqueTiles& tiles) {
  return (std::size_t(tiles.columns()) * std::size_t(tiles.rows()) + 7) / 8;
}

}  // namespace

void append_opaque_news(int region, const OpaqueTiles& tiles, Bytes& news) {
  append(news, std::int32_t{region});
  std::vector<std::uint8_t> bitmap(bitmap_bytes(tiles), 0);
  for (int row = 0; row < tiles.rows(); ++row) {
    for (int column = 0; column < tiles.columns(); ++column) {
      const int tile = row * tiles.columns() + column;
      if (tiles.is_opaque(column, row)) bitmap[std::size_t(tile / 8)] |= std::uint8_t(1U << (tile % 8));
    }
  }
  for (const std::uint8_t byte : bitmap) append(news, byte);
}

void read_opaque_news(std::span<const std::byte> news, std::vector<OpaqueTiles>& known) {
  std::size_t at = 0;
  while (at < news.size()) {
    std::int32_t region = -1;
    if (!take(news, at, region) || region < 0 || std::size_t(region) >= known.size() ||
        news.size() - at < bitmap_bytes(known[std::size_t(region)]))
      throw RunError(fmt::format("news of opaque tiles are not understood at byte {}", at),
                     "all ranks must run the same build");
    OpaqueTiles& tiles = known[std::size_t(region)];
    for (int row = 0; row < tiles.rows(); ++row) {
      for (int column = 0; column < tiles.columns(); ++column) {
        const int tile = row * tiles.columns() + column;
        if ((std::to_integer<unsigned>(news[at + std::size_t(tile / 8)]) >> (tile % 8) & 1U) != 0)
          tiles.set_opaque(column, row);
      }
    }
    tiles.sum_up();
    at += bitmap_bytes(tiles);
  }
}

}  // namespace ringsplat
