#include "splat_engine/row_band.hpp"

#include <bit>
#include <cmath>

namespace ringsplat {
namespace {

/// Calls use(first, count) for each run of set bits, lowest first.
template <class Use>
void for_each_bit_run(std::uint64_t bits, const Use& use) {
  for (int first = 0; bits != 0;) {
    const int skipped = std::countr_zero(bits), count = std::countr_one(bits >> skipped);
    first += skipped;
    use(first, count);
    first += count;
    // Shifts in two steps: shifting a 64-bit word by 64 is undefined.
    bits = bits >> skipped >> (count - 1) >> 1;
  }
}

/// Mask of the block's voxels that lie in these columns.
std::uint64_t in_columns(const VisibleBlock& block, Columns columns) {
  constexpr std::uint64_t all = ~std::uint64_t{0};
  constexpr std::uint32_t width = 64;
  const std::uint32_t from = columns.first > block.first ? columns.first - block.first : 0,
                      behind = columns.end < block.first + width ? block.first + width - columns.end : 0;
  return from < width && behind < width ? block.mask & all << from & all >> behind : 0;
}

/// Appends the values to the payload and empties them.
void move_values(auto& values, Bytes& payload) {
  const auto raw = std::as_bytes(std::span(values));
  const std::size_t at = payload.size();
  payload.resize(at + raw.size());
  std::copy(raw.begin(), raw.end(), payload.begin() + std::ptrdiff_t(at));
  values.clear();
}

}  // namespace

EncoderFrame::EncoderFrame(const SplatFrame& splat_frame)
    : frame(splat_frame),
      geometry(frame.geometry),
      classifier(frame.shown.transfer_function, geometry.grid.type,
                 frame.shown.opacity_correction ? geometry.traversal.slice_distance
                                                : double(frame.shown.reduction.factor)),
      reach(kernel_reach(frame.footprint)),
      stride(pass_stride(frame.splats.kernel_radius)) {
  const ViewTransform& view = geometry.view;
  const glm::dvec3& light = frame.shown.light;
  if (frame.shown.shading == Shading::phong)
    phong.emplace(frame.shown.material, view.right * light.x + view.up * light.y + view.to_viewer * light.z,
                  view.to_viewer);
  for (int region = 0; region < geometry.regions.count(); ++region) {
    rects.push_back(geometry.regions.rect(region));
    opaque.emplace_back(rects.back().width(), rects.back().height());
  }
}

std::vector<int> row_bounds(const SliceRuns& runs, int height, int most) {
  if (runs.empty()) return {0};
  if (most == 1) return {0, height};
  std::vector<std::int64_t> before{0};  // by row: possibly visible voxels in the rows before
  for (int row = 0; row < height; ++row) {
    std::int64_t voxels = 0;
    for (const ColumnRun& run : runs.of_row(row)) voxels += run.end - run.first;
    before.push_back(before.back() + voxels);
  }
  // Waking a thread costs as much as some hundred voxels.
  constexpr std::int64_t worth_a_thread = 256;
  const auto bands = std::clamp<std::int64_t>(before.back() / worth_a_thread, 1, most);
  std::vector<int> bounds{0};
  for (std::int64_t band = 1; band < bands; ++band) {
    const auto cut = std::lower_bound(before.begin(), before.end(), before.back() * band / bands);
    const int row = int(cut - before.begin());
    if (row > bounds.back() && row < height) bounds.push_back(row);
  }
  bounds.push_back(height);
  return bounds;
}

RowBand::RowBand(const EncoderFrame& frame)
    : frame_(frame),
      dda_(frame.geometry.view, frame.geometry.traversal.axis,
           frame.geometry.grid.slice_width(frame.geometry.traversal.axis)),
      counts_(frame.rects.size()),
      parts_(frame.rects.size()),
      inverse_step_(1.0 / glm::dvec2(frame.geometry.view.linear[in_plane(frame.geometry.traversal.axis).u])),
      beyond_(double(frame.reach.x) + 0.51, double(frame.reach.y) + 0.51) {}

void RowBand::begin(const SliceView& slice, VisibleVoxels& voxels, int first, int end) {
  slice_ = slice;
  voxels_ = &voxels;
  row_ = first;
  end_ = end;
  visible_ = outside_ = 0;
}

bool RowBand::work(int visible_at_most, int voxels_at_most) {
  int visible = 0, voxels = 0;
  for (; row_ < end_ && visible < visible_at_most && voxels < voxels_at_most; ++row_) {
    row_offset_ = row_ % frame_.stride;
    find_row();
    visible += int(found_.visible);
    voxels += slice_.width;
    if (found_.visible > 0) encode_row();
  }
  visible_ += std::uint64_t(visible);
  return row_ >= end_;
}

void RowBand::find_row() {
  const auto runs = voxels_->runs().of_row(row_);
  if (runs.empty()) return found_.take({}, 0, 0);
  dda_.begin_row(slice_.index, row_);
  Columns columns = reaching(0, 0, frame_.geometry.width, {0, std::uint32_t(slice_.width)});
  if (!columns.empty()) columns = reaching(1, 0, frame_.geometry.height, columns);
  for (const ColumnRun& run : runs) {
    const int first = std::max(run.first, int(columns.first)), end = std::min(run.end, int(columns.end));
    outside_ += std::uint64_t(run.end - run.first - std::max(end - first, 0));
  }
  if (columns.empty())
    found_.take({}, 0, 0);
  else
    found_.take(voxels_->of_row(slice_, row_), columns.first, columns.end);
}

Columns RowBand::reaching(int along, double low, double high, Columns columns) const {
  low -= beyond_[along];
  high += beyond_[along];
  const double start = dda_.row_start()[along], inverse = inverse_step_[along];
  if (!std::isfinite(inverse)) return start >= low && start <= high ? columns : Columns{0, 0};
  const double a = (low - start) * inverse, b = (high - start) * inverse;
  const double first = std::max(std::min(a, b), double(columns.first)),
               last = std::min(std::max(a, b), double(columns.end) - 1);
  if (!(first <= last)) return {0, 0};
  const auto truncated = static_cast<std::uint32_t>(static_cast<std::int64_t>(first));
  return {truncated + (double(truncated) < first),
          static_cast<std::uint32_t>(static_cast<std::int64_t>(last)) + 1};
}

void RowBand::encode_row() {
  const VisibleBlock &front = found_.blocks.front(), &back = found_.blocks.back();
  const Columns all{front.first + std::uint32_t(std::countr_zero(front.mask)),
                    back.first + std::uint32_t(std::bit_width(back.mask))};
  const PixelWindow window = hull(window_of(all.first), window_of(all.end - 1));
  const PixelRect touched = frame_.geometry.regions.touched(window);
  const int region = touched.y0 * frame_.geometry.regions.columns() + touched.x0;
  if (touched.width() == 1 && touched.height() == 1 && hidden(region, window) == OpaqueTiles::Cover::none)
    return append_row(region);
  find_pieces(touched, all);
  if (pieces_.empty()) return;
  packed_.resize(found_.visible);
  pack_samples(packed_.data());
  for (const Piece& piece : pieces_) append(piece);
}

void RowBand::append_row(int region) {
  Part& part = parts_[std::size_t(region)];
  const std::size_t at = part.voxels.size();
  part.voxels.resize(at + found_.visible);
  pack_samples(part.voxels.data() + at);
  for (const VisibleBlock& block : found_.blocks) {
    part.blocks.push_back({std::uint32_t(row_), block.first, block.mask});
    count(region, int(block.first), block.mask);
  }
}

void RowBand::pack_samples(PackedVoxel* voxels) {
  const NormalCode* normals = frame_.phong ? slice_.normals_of_row(row_) : nullptr;
  make_samples(frame_.classifier, {slice_.values_of_row(row_), normals, slice_.width},
               frame_.phong ? &*frame_.phong : nullptr, found_);
  pack(&found_.samples.front().r, found_.visible, voxels);
}

void RowBand::find_pieces(const PixelRect& touched, Columns all) {
  pieces_.clear();
  for (int y = touched.y0; y < touched.y1; ++y) {
    const int first_region = y * frame_.geometry.regions.columns();
    const PixelRect& pixels = rect(first_region);
    const Columns columns = reaching(1, pixels.y0, pixels.y1, all);
    if (columns.empty()) continue;
    for (int x = touched.x0; x < touched.x1; ++x) find_pieces_of(first_region + x, columns);
  }
}

void RowBand::find_pieces_of(int region, Columns columns) {
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

OpaqueTiles::Cover RowBand::cover_of(int region, std::uint32_t first, std::uint32_t last) const {
  constexpr double rounding = 1e-6;
  const PixelRect& pixels = rect(region);
  const double x = dda_.row_start().x - pixels.x0 - 0.5, y = dda_.row_start().y - pixels.y0 - 0.5;
  const double xa = x + dda_.steps_x()[first], xb = x + dda_.steps_x()[last];
  const double ya = y + dda_.steps_y()[first], yb = y + dda_.steps_y()[last];
  const double before_x = double(frame_.reach.x) + rounding, before_y = double(frame_.reach.y) + rounding;
  return opaque(region).cover(std::min(xa, xb) - before_x, std::min(ya, yb) - before_y,
                              std::max(xa, xb) + before_x + 1, std::max(ya, yb) + before_y + 1);
}

std::uint64_t RowBand::seen_of(int region, std::uint32_t first, std::uint64_t mask) const {
  std::uint64_t seen = 0;
  for_each_bit_run(mask,
                   [&](int begin, int count) { seen |= seen_of_run(region, first, begin, begin + count); });
  return seen;
}

std::uint64_t RowBand::seen_of_run(int region, std::uint32_t first, int begin, int end) const {
  const OpaqueTiles::Cover hidden =
      cover_of(region, first + std::uint32_t(begin), first + std::uint32_t(end - 1));
  if (hidden == OpaqueTiles::Cover::all) return 0;
  if (hidden == OpaqueTiles::Cover::none || end - begin == 1)
    return ~std::uint64_t{0} >> (64 - (end - begin)) << begin;
  const int middle = begin + (end - begin) / 2;
  return seen_of_run(region, first, begin, middle) | seen_of_run(region, first, middle, end);
}

void RowBand::append(const Piece& piece) {
  const VisibleBlock& block = found_.blocks[piece.block];
  Part& part = parts_[std::size_t(piece.region)];
  part.blocks.push_back({std::uint32_t(row_), block.first, piece.mask});
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

void RowBand::append_parts(int region, std::span<RowBand> bands, Bytes& payload) {
  BlockGroup group{region, 0, 0};
  for (const RowBand& band : bands) {
    const Part& part = band.parts_[std::size_t(region)];
    group.blocks += std::uint32_t(part.blocks.size());
    group.voxels += std::uint32_t(part.voxels.size());
  }
  ringsplat::append(payload, group);
  for (RowBand& band : bands) move_values(band.parts_[std::size_t(region)].blocks, payload);
  for (RowBand& band : bands) move_values(band.parts_[std::size_t(region)].voxels, payload);
}

void RowBand::clear_counts() {
  for (const int region : used_) counts_[std::size_t(region)] = {};
  used_.clear();
}

}  // namespace ringsplat
