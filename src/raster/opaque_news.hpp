#pragma once
#include <span>
#include <vector>

#include "raster/opaque_tiles.hpp"
#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// Appends one region's opaque tiles as they travel: the region's number, then a bit for each tile, row by
/// row.
void append_opaque_news(int region, const OpaqueTiles& tiles, Bytes& news);

/// Adds the news of any number of regions to `known`, which is indexed by region. Throws RunError when the
/// bytes name no region or end too early.
void read_opaque_news(std::span<const std::byte> news, std::vector<OpaqueTiles>& known);

}  // namespace ringsplat
