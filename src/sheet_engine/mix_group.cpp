#include <algorithm>
#include <bit>
#include <cstring>

#include "sheet_engine/paint_group.hpp"

namespace ringsplat {
namespace {

/// A group's pixels, row by row.
struct GroupPixels {
  alignas(64) std::array<float, 4 * group_side * group_side> rgba;
};
constexpr std::ptrdiff_t group_row = 4 * group_side;

/// A pixel as one of several volumes alone would make it, and its opacity of what the pixel let through.
struct Added {
  const float* rgba;
  float opacity;
};

/// What of each volume's light gets out of a slab, which grows evenly in it as its opacity does from 0 to a:
/// the integral over t, from 0 to 1, of the product of (1 - a t) over the others.
void find_shares(std::span<const Added> all, float* shares) {
  // Gauss and Legendre's rule, exact for polynomials of degree five and so for six volumes.
  constexpr struct {
    float at, weight;
  } rule[] = {{0.11270167F, 5.0F / 18}, {0.5F, 8.0F / 18}, {0.88729833F, 5.0F / 18}};
  std::fill_n(shares, all.size(), 0.0F);
  for (const auto& [at, weight] : rule) {
    std::array<float, most_channels> before;
    float product = weight;
    for (std::size_t i = 0; i < all.size(); product *= 1 - at * all[i].opacity, ++i) before[i] = product;
    product = 1;
    for (std::size_t i = all.size(); i-- > 0; product *= 1 - at * all[i].opacity)
      shares[i] += before[i] * product;
  }
}

/// Puts into `pixel` what volumes add to it that share a slab. `alone`: it behind each by itself. Opacities
/// come to that of all volumes in turn, and no volume is before another. Those that add nothing change no
/// bit.
void mix_pixel(float* pixel, std::span<const float* const> alone) {
  std::array<Added, most_channels> adding;
  std::size_t count = 0;
  const float over_through = 1 / (1 - pixel[3]);
  for (const float* const one : alone)
    if (std::memcmp(one, pixel, 4 * sizeof(float)) != 0)
      adding[count++] = {one, std::clamp((one[3] - pixel[3]) * over_through, 0.0F, 1.0F)};
  if (count == 0) return;
  if (count == 1) return static_cast<void>(std::copy_n(adding[0].rgba, 4, pixel));
  std::array<float, most_channels> shares;
  find_shares(std::span(adding).first(count), shares.data());
  std::array<float, 4> sum;
  std::copy_n(pixel, 4, sum.data());
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 4; ++c) sum[c] += shares[i] * (adding[i].rgba[c] - pixel[c]);
  std::copy_n(sum.data(), 4, pixel);
}

/// Of a tile in a group. `alone`: the group's pixels behind each volume by itself, in rows of group_row.
void mix_tile(const PixelGroup& group, int tile, std::span<const float* const> alone) {
  constexpr int tiles_a_row = group_side / tile_side;
  const int x0 = tile % tiles_a_row * tile_side, y0 = tile / tiles_a_row * tile_side;
  for (int y = y0; y < std::min(y0 + tile_side, group.height); ++y)
    for (int x = x0; x < std::min(x0 + tile_side, group.width); ++x) {
      std::array<const float*, most_channels> pixels;
      for (std::size_t i = 0; i < alone.size(); ++i) pixels[i] = alone[i] + y * group_row + 4 * x;
      mix_pixel(group.rgba + y * group.row_floats + 4 * x, std::span(pixels).first(alone.size()));
    }
}

MaskedSlabs part_of(const MaskedSlabs& all, std::size_t first, std::size_t end) {
  return {all.slabs.subspan(first, end - first), all.masks + std::ptrdiff_t(first) * all.stride, all.stride};
}

/// The channels that show something of a slab, a bit for each.
unsigned shown_in(std::span<const PaintedChannel> channels, std::size_t slab) {
  unsigned shown = 0;
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (channels[i].slabs.masks[std::ptrdiff_t(slab) * channels[i].slabs.stride] != 0) shown |= 1U << i;
  return shown;
}

void mix_slab(std::span<const PaintedChannel> channels, const PixelGroup& group, std::size_t slab) {
  const auto mask_of = [&](const PaintedChannel& channel) {
    return channel.slabs.masks[std::ptrdiff_t(slab) * channel.slabs.stride];
  };
  TileMask shown = 0, mixed = 0;  // tiles of one volume or more, and of several
  for (const PaintedChannel& channel : channels) {
    mixed = TileMask(mixed | (shown & mask_of(channel)));
    shown = TileMask(shown | mask_of(channel));
  }
  GroupPixels pixels[most_channels];
  const float* alone[most_channels];
  std::size_t count = 0;
  for (const PaintedChannel& channel : channels) {
    const auto paint = [&](TileMask tiles, const PixelGroup& to) {
      if (tiles != 0) paint_group(*channel.paint, to, {channel.slabs.slabs.subspan(slab, 1), &tiles, 1});
    };
    paint(TileMask(mask_of(channel) & ~mixed), group);
    if ((mask_of(channel) & mixed) == 0) continue;
    PixelGroup copy = group;
    copy.rgba = pixels[count].rgba.data();
    copy.row_floats = group_row;
    for (int y = 0; y < group.height; ++y)
      std::copy_n(group.rgba + y * group.row_floats, 4 * group.width, copy.rgba + y * group_row);
    paint(TileMask(mask_of(channel) & mixed), copy);
    alone[count++] = copy.rgba;
  }
  for (unsigned left = mixed; left != 0; left &= left - 1)
    mix_tile(group, std::countr_zero(left), {alone, count});
}

}  // namespace

void mix_group(std::span<const PaintedChannel> channels, const PixelGroup& group) {
  const std::size_t slabs = channels.front().slabs.slabs.size();
  for (std::size_t first = 0; first < slabs;) {
    // Many slabs in turn of one volume are painted at once.
    std::size_t end = first;
    unsigned shown = 0, more = 0;
    for (; end < slabs; ++end, shown = more)
      if (more = shown | shown_in(channels, end); std::popcount(more) > 1) break;
    if (shown != 0) {
      const PaintedChannel& only = channels[std::size_t(std::countr_zero(shown))];
      paint_group(*only.paint, group, part_of(only.slabs, first, end));
    }
    if (end < slabs) mix_slab(channels, group, end++);
    first = end;
  }
}

}  // namespace ringsplat
