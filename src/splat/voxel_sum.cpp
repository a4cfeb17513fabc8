#include "splat/voxel_sum.hpp"

#include <bit>
#include <cmath>
#include <glm/vec4.hpp>
#include <utility>

namespace ringsplat {
namespace {

/// A bit for each of the 64 places x, x + step, … that lies within [low, high]. A step is 1, 2 or 4.
std::uint64_t places_within(std::int64_t x, int step, std::int64_t low, std::int64_t high) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  if (x >= low && x + 63 * step <= high) return all;
  const int shift = std::countr_zero(unsigned(step));
  const std::int64_t first = std::max<std::int64_t>((low - x + step - 1) >> shift, 0),
                     last = std::min<std::int64_t>((high - x) >> shift, 63);
  return first <= last ? all << first & all >> (63 - last) : 0;
}

/// How many of the voxels have a weight above zero in the region. Those whose windows' columns all lie inside
/// are alike; the others are looked at one by one.
std::uint64_t count_drawn(const AlignedSlice& slice, const SliceBuffer& buffer, std::int64_t x,
                          std::int64_t y, std::uint64_t mask) {
  const auto reaches = [&](std::uint64_t bits) {
    const std::int64_t first = x + std::countr_zero(bits) * slice.step_x;
    return std::any_of(slice.covered.begin(), slice.covered.end(),
                       [&](const glm::ivec2& at) { return buffer.holds(int(first) + at.x, int(y) + at.y); });
  };
  const std::uint64_t inside =
      mask & places_within(x, slice.step_x, slice.reach_x, buffer.width - slice.reach_x - 2);
  const bool rows_inside = y >= slice.reach_y && y + slice.reach_y + 1 < buffer.height;
  std::uint64_t drawn = 0;
  if (inside != 0 && (rows_inside || reaches(inside))) drawn = std::uint64_t(std::popcount(inside));
  for (std::uint64_t edge = mask & ~inside; edge != 0; edge &= edge - 1) drawn += reaches(edge);
  return drawn;
}

/// What the voxel adds with weight 1; nothing where no footprint gives its opacity.
glm::vec4 premultiplied(const PackedVoxel& voxel, double weight) {
  const VoxelColour straight = unpack(voxel);
  const auto weighted = float(double(straight.opacity) * weight);
  const float opacity = std::abs(weighted) < largest_coefficient ? weighted : 0.0F;
  const float scale = opacity * (1.0F / 65535.0F);
  return {float(straight.red) * scale, float(straight.green) * scale, float(straight.blue) * scale, opacity};
}

/// Places the voxels of a block's mask. (x, y): the place of the mask's bit 0, inside the buffer or not.
void place_row(const AlignedSlice& slice, const VoxelRows& to, std::int64_t x, std::int64_t y,
               std::uint64_t mask, const PackedVoxel* voxels) {
  float* const row = to.buffer.origin + y * to.buffer.row_floats;
  std::uint64_t* const filled = to.filled + y * std::ptrdiff_t(to.row_words);
  const auto fill = [&](std::int64_t pixel, std::uint64_t bits) {
    const auto place = std::uint64_t(pixel + to.left);
    filled[place / 64] |= bits << place % 64;
    if (place % 64 > 0) filled[place / 64 + 1] |= bits >> (64 - place % 64);
  };
  if (slice.step_x == 1) fill(x + std::countr_zero(mask), mask >> std::countr_zero(mask));
  for (; mask != 0; mask &= mask - 1, ++voxels) {
    const glm::vec4 colour = premultiplied(*voxels, slice.opacity_weight);
    const std::int64_t first = x + std::countr_zero(mask) * slice.step_x;
    for (std::int64_t pixel = first; pixel < first + slice.step_x; ++pixel) {
      for (int c = 0; c < 4; ++c) row[4 * pixel + c] = colour[c];
      if (slice.step_x > 1) fill(pixel, 1);
    }
  }
}

}  // namespace

DrawnBlocks place_voxels(const AlignedSlice& slice, VoxelRows& to, const VoxelRuns& blocks,
                         std::uint64_t most) {
  // Windows that meet the region have their anchor at most reach + 1 before it, or reach behind it.
  const std::int64_t least_x = -slice.reach_x - 1, most_x = to.buffer.width + slice.reach_x - 1,
                     least_y = -slice.reach_y - 1, most_y = to.buffer.height + slice.reach_y - 1;
  DrawnBlocks placed;
  std::uint64_t seen = 0;
  while (placed.blocks < blocks.count && seen < most) {
    VoxelRun block;
    std::memcpy(&block, blocks.blocks + placed.blocks * sizeof block, sizeof block);
    ++placed.blocks;
    const PackedVoxel* voxels = blocks.voxels + seen;
    seen += std::uint64_t(std::popcount(block.mask));
    const std::int64_t x = to.x + std::int64_t{slice.step_x} * block.first,
                       y = to.y + std::int64_t{slice.step_y} * block.row;
    if (y < least_y || y > most_y) continue;
    const std::uint64_t within = block.mask & places_within(x, slice.step_x, least_x, most_x);
    if (within == 0) continue;
    voxels += std::popcount(block.mask & ((within & -within) - 1));
    place_row(slice, to, x, y, within, voxels);
    placed.counts.drawn += count_drawn(slice, to.buffer, x, y, within);
    to.top = std::min(to.top, int(y));
    to.bottom = std::max(to.bottom, int(y) + 1);
  }
  placed.counts.clipped = seen - placed.counts.drawn;
  return placed;
}

VoxelSum::VoxelSum(AlignedFrame frame, const PixelRect& largest) : frame_(std::move(frame)) {
  const KernelReach reach = kernel_reach(frame_.footprint);
  const Margins margins = window_margins(reach);
  rows_.left = int(in_whole_blocks(margins.left));
  rows_.buffer = make_slice_buffer(margins, largest);

  const int inside = int(in_whole_blocks(largest.width())), behind = int(2 * reach.x) + 1 + largest_step;
  const std::size_t words = std::size_t(rows_.left + inside + behind) / 64 + 2;  // the last one is 0
  const std::size_t above = std::size_t(reach.y) + 1,
                    anchors = above + std::size_t(largest.height() + reach.y);
  filled_.assign(1 + anchors * words + 1, 0);
  covered_.assign(words, 0);
  rows_.row_words = words;
  rows_.filled = filled_.data() + 1 + above * words;
}

void VoxelSum::begin(RegionImage& image, int slice) {
  if (std::exchange(slice_index_, slice) != slice) slice_ = frame_.slice(slice);
  image_ = &image;
  SliceBuffer& buffer = rows_.buffer;
  buffer.height = image.rect().height();
  if (!inside_.empty() && buffer.width == image.rect().width()) return;
  buffer.width = image.rect().width();
  inside_.assign(rows_.row_words, 0);
  const int end = rows_.left + int(in_whole_blocks(buffer.width));
  for (int pixel = rows_.left; pixel < end; ++pixel)
    inside_[std::size_t(pixel) / 64] |= std::uint64_t{1} << pixel % 64;
  rows_.inside = inside_.data();
}

DrawnBlocks VoxelSum::draw(const VoxelRuns& blocks, std::uint64_t most) {
  rows_.x = slice_.anchor_x - image_->rect().x0;
  rows_.y = slice_.anchor_y - image_->rect().y0;
  const DrawnBlocks drawn = place_voxels(slice_, rows_, blocks, most);
  reached_ |= drawn.counts.drawn > 0;
  return drawn;
}

}  // namespace ringsplat
