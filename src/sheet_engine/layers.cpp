#include "sheet_engine/layers.hpp"

#include <tuple>

#include "base/half.hpp"
#include "net/message.hpp"

namespace ringsplat {
namespace {

/// A region's pixels in a layer: `bytes` of runs.
struct RegionHead {
  std::int64_t region;
  std::uint64_t bytes;
};
/// Pixels of the picture's region that are not transparent, in the order of its rows.
struct Run {
  std::uint32_t first, pixels;
};
constexpr std::size_t halves = 4;
constexpr float largest_half = 65504;

std::size_t bytes_of(const Run& run) { return run.pixels * halves * sizeof(std::uint16_t); }

void append_run(const float* row, const Run& run, Bytes& out) {
  append(out, run);
  const std::size_t at = out.size();
  out.resize(at + bytes_of(run));
  for (std::size_t k = 0; k < run.pixels * halves; ++k) {
    const std::uint16_t half = to_half(std::clamp(row[k], 0.0F, largest_half) + 0.0F);
    std::memcpy(out.data() + at + k * sizeof half, &half, sizeof half);
  }
}

/// Runs end with rows, as these lie apart.
void append_runs(RegionImage& image, int width, int height, Bytes& out) {
  for (int y = 0; y < height; ++y) {
    const float* const row = image.pixels() + y * image.row_floats();
    const auto shows = [row](int x) { return row[4 * x + 3] > 0; };
    for (int x = 0; x < width;) {
      const int first = x;
      while (x < width && shows(x)) ++x;
      if (x > first)
        append_run(row + 4 * first, {std::uint32_t(y * width + first), std::uint32_t(x - first)}, out);
      while (x < width && !shows(x)) ++x;
    }
  }
}

}  // namespace

std::vector<FramePlan::Share> shares_of_layers(const SheetFrame& frame, int renderers) {
  const FrameGeometry& g = frame.geometry;
  std::vector<FramePlan::Share> shares(static_cast<std::size_t>(renderers));
  const int tiles = g.layers.picture.count();
  for (int region = 0; region < g.regions.count(); ++region) {
    const int renderer = frame.drawers[std::size_t(region)],
              taker = frame.plan.tiles[std::size_t(region % tiles)].renderer;
    if (renderer == nobody || taker == nobody) continue;
    FramePlan::Share& share = shares[std::size_t(renderer)];
    share.takers.push_back(taker);
    const int first = region / tiles * g.layers.slices,
              last = std::min(first + g.layers.slices, g.slices) - 1;
    const std::pair<int, int> steps =
        std::minmax(frame.geometry.slice_at(first), frame.geometry.slice_at(last));
    const int begin = std::max(steps.first - frame.reach() + 1, 0),
              end = std::min(steps.second + frame.reach() + 1, g.slices);
    const bool is_first = share.end == 0;
    share.first = is_first ? begin : std::min(share.first, begin);
    share.end = std::max(share.end, end);
  }
  for (auto& [first, end, takers] : shares) {
    std::ranges::sort(takers);
    takers.erase(std::unique(takers.begin(), takers.end()), takers.end());
  }
  return shares;
}

void append_layers(const SheetFrame& frame, OwnedImages& images, int tiles_of, Bytes& out) {
  const Regions& picture = frame.geometry.layers.picture;
  for (std::size_t slot = 0; slot < images.count(); ++slot) {
    const int region = images.owned()[slot], tile = region % picture.count();
    if (!images.image(slot).touched() || frame.plan.tiles[std::size_t(tile)].renderer != tiles_of) continue;
    const std::size_t head_at = out.size();
    append(out, RegionHead{});
    const PixelRect rect = picture.rect(tile);
    append_runs(images.image(slot), rect.width(), rect.height(), out);
    const RegionHead head{region, out.size() - head_at - sizeof(RegionHead)};
    std::memcpy(out.data() + head_at, &head, sizeof head);
  }
}

void LayerSum::begin_frame(const SheetFrame& frame, int renderer) {
  frame_ = &frame;
  renderer_ = renderer;
  pieces_.clear();
}

void LayerSum::add(std::span<const std::byte> bytes) {
  const FrameGeometry& g = frame_->geometry;
  const int tiles = g.layers.picture.count();
  for (std::size_t at = 0; at < bytes.size();) {
    RegionHead head{};
    const bool complete = take(bytes, at, head) && head.bytes <= bytes.size() - at;
    if (!complete || head.region < 0 || head.region >= g.regions.count() ||
        frame_->plan.tiles[std::size_t(head.region % tiles)].renderer != renderer_)
      throw OtherBuild(
          fmt::format("Renderer {} got {} bytes that are no layers of its tiles", renderer_, bytes.size()));
    const auto layer = int(head.region / tiles);
    pieces_.push_back(
        {int(head.region % tiles), g.traversal.ascending ? layer : -layer, bytes.subspan(at, head.bytes)});
    at += head.bytes;
  }
}

void LayerSum::deliver(const std::function<void(int, Bytes)>& deliver) {
  std::ranges::sort(pieces_, {}, [](const Piece& piece) { return std::tuple(piece.tile, piece.order); });
  for (auto piece = pieces_.begin(); piece != pieces_.end();) {
    const int tile = piece->tile;
    Bytes body = Message::body_buffer();
    body.insert(body.end(), frame_->plan.tiles[std::size_t(tile)].bytes, std::byte{0});
    const std::span rgba(reinterpret_cast<float*>(body.data() + sizeof(Header)),
                         (body.size() - sizeof(Header)) / sizeof(float));
    for (; piece != pieces_.end() && piece->tile == tile; ++piece) composite(*piece, rgba);
    deliver(tile, std::move(body));
  }
}

void LayerSum::composite(const Piece& piece, std::span<float> rgba) const {
  const auto threshold = static_cast<float>(frame_->shown.opaque_threshold);
  Run run{};
  for (std::size_t at = 0; at < piece.runs.size(); at += bytes_of(run)) {
    if (!take(piece.runs, at, run) || bytes_of(run) > piece.runs.size() - at ||
        std::uint64_t{run.first} + run.pixels > rgba.size() / 4)
      throw OtherBuild(
          fmt::format("Renderer {} got a layer of tile {} that is cut short", renderer_, piece.tile));
    const std::byte* from = piece.runs.data() + at;
    float* to = rgba.data() + std::size_t{4} * run.first;
    for (std::uint32_t k = 0; k < run.pixels; ++k, to += 4, from += halves * sizeof(std::uint16_t)) {
      const float left = 1 - to[3];
      if (left < threshold) continue;
      std::uint16_t pixel[halves];
      std::memcpy(pixel, from, sizeof pixel);
      for (std::size_t c = 0; c < halves; ++c) to[c] += left * from_half(pixel[c]);
    }
  }
}

}  // namespace ringsplat
