#include <algorithm>
#include <bit>
#include <vector>

#include "sheet_engine/paint_group.hpp"

namespace ringsplat {
namespace {

/// A group's pixels, row by row.
struct GroupPixels {
  alignas(64) std::array<float, 4 * group_side * group_side> rgba;
};
constexpr std::ptrdiff_t group_row = 4 * group_side;

/// Gauss and Legendre's rule from 0 to 1, exact for polynomials of degree five and so for six volumes.
constexpr struct {
  float at, weight;
} rule[] = {{0.11270167F, 5.0F / 18}, {0.5F, 8.0F / 18}, {0.88729833F, 5.0F / 18}};

/// Puts into `pixel` what volumes add to it that share a slab. `alone`: it behind each by itself.
///
/// In the slab each volume's opacity grows evenly from 0 to a, so that the light of one passes what the
/// others have before it: its share is the integral over t, from 0 to 1, of the product of (1 - a t) over the
/// others. The opacity is that of all volumes in turn, and no volume is before another.
void mix_pixel(float* pixel, std::span<const float* const> alone) {
  const float through = 1 - pixel[3];
  if (!(through > 0)) return;
  std::array<float, most_channels> opacity{}, share{};
  for (std::size_t i = 0; i < alone.size(); ++i)
    opacity[i] = std::clamp((alone[i][3] - pixel[3]) / through, 0.0F, 1.0F);
  for (const auto& [at, weight] : rule) {
    float all = weight;
    for (std::size_t i = 0; i < alone.size(); ++i) all *= 1 - at * opacity[i];
    for (std::size_t i = 0; i < alone.size(); ++i) share[i] += all / (1 - at * opacity[i]);
  }
  float sum[4] = {pixel[0], pixel[1], pixel[2], pixel[3]};
  for (std::size_t i = 0; i < alone.size(); ++i)
    for (int c = 0; c < 4; ++c) sum[c] += share[i] * (alone[i][c] - pixel[c]);
  std::copy_n(sum, 4, pixel);
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

void mix_slab(std::span<const PaintedChannel> channels, unsigned shown, const PixelGroup& group,
              std::size_t slab) {
  GroupPixels pixels[most_channels];
  const float* alone[most_channels];
  std::size_t count = 0;
  for (; shown != 0; shown &= shown - 1, ++count) {
    float* const to = pixels[count].rgba.data();
    for (int y = 0; y < group.height; ++y)
      std::copy_n(group.rgba + y * group.row_floats, 4 * group.width, to + y * group_row);
    PixelGroup copy = group;
    copy.rgba = to;
    copy.row_floats = group_row;
    const PaintedChannel& channel = channels[std::size_t(std::countr_zero(shown))];
    paint_group(*channel.paint, copy, part_of(channel.slabs, slab, slab + 1));
  }
  for (int y = 0; y < group.height; ++y)
    for (int x = 0; x < group.width; ++x) {
      for (std::size_t i = 0; i < count; ++i) alone[i] = pixels[i].rgba.data() + y * group_row + 4 * x;
      mix_pixel(group.rgba + y * group.row_floats + 4 * x, {alone, count});
    }
}

}  // namespace

void mix_group(std::span<const PaintedChannel> channels, const PixelGroup& group) {
  const std::size_t slabs = channels.front().slabs.slabs.size();
  for (std::size_t first = 0, end = 0; first < slabs; first = end) {
    // Many slabs in turn of one volume are painted at once.
    unsigned shown = shown_in(channels, first);
    for (end = first + 1; end < slabs; ++end) {
      const unsigned next = shown | shown_in(channels, end);
      if (std::popcount(next) > 1) break;
      shown = next;
    }
    if (std::popcount(shown) > 1)
      mix_slab(channels, shown, group, first);
    else if (shown != 0)
      paint_group(*channels[std::size_t(std::countr_zero(shown))].paint, group,
                  part_of(channels[std::size_t(std::countr_zero(shown))].slabs, first, end));
  }
}

}  // namespace ringsplat
