#include "raster/opaque_tiles.hpp"

#include <fmt/format.h>

#include "base/byte_stream.hpp"

namespace ringsplat {
namespace {

std::size_t bitmap_bytes(const OpaqueTiles& tiles) { return (tiles.flags().size() + 7) / 8; }

}  // namespace

void append_opaque_news(int region, const OpaqueTiles& tiles, Bytes& news) {
  append(news, std::int32_t{region});
  const std::size_t at = news.size();
  news.resize(at + bitmap_bytes(tiles), std::byte{0});
  for (std::size_t tile = 0; tile < tiles.flags().size(); ++tile)
    news[at + tile / 8] |= std::byte(tiles.flags()[tile] << (tile % 8));
}

void read_opaque_news(std::span<const std::byte> news, std::vector<OpaqueTiles>& known) {
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
