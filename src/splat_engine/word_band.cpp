#include <cstring>

#include "base/byte_stream.hpp"
#include "splat_engine/row_band.hpp"

namespace ringsplat {
namespace {

/// One region's splats of a slice in wire format: groups of a head and its splats.
struct WordPart {
  Bytes bytes;
  std::size_t group = 0;  ///< offset of the open group's head
  SplatGroup head{};

  void close_group() { std::memcpy(bytes.data() + group, &head, sizeof head); }
};

/// The paper's payload: every splat's quadratic and colour in six words, sorted by region (Neumann 1992,
/// section 3).
class WordBand final : public RowBand {
 public:
  explicit WordBand(const EncoderFrame& frame) : RowBand(frame), parts_(frame.rects.size()) {}

 private:
  void encode_row(int) override {
    auto sample = make_samples().begin();
    for (const VisibleBlock& block : found_.blocks)
      for (std::uint64_t mask = block.mask; mask != 0; mask &= mask - 1)
        place(int(block.first) + std::countr_zero(mask), *sample++);
  }

  /// Makes the voxel's splat and puts it into every region its kernel reaches: one, two or four; more when
  /// kernels are larger than regions.
  void place(int column, const ClassifiedSample& sample) {
    const glm::dvec3 position = dda_.position(std::uint32_t(column));
    const Anchored at = anchor(position.x, position.y);
    const PixelWindow window = pixel_window(at, frame_.reach);
    const PixelRect touched = frame_.geometry.regions.touched(window);
    for (int y = touched.y0; y < touched.y1; ++y)
      for (int x = touched.x0; x < touched.x1; ++x)
        put(y * frame_.geometry.regions.columns() + x, at, window, column, sample);
  }

  void put(int region, const Anchored& at, const PixelWindow& window, int column,
           const ClassifiedSample& sample) {
    if (hidden(region, window) == OpaqueTiles::Cover::all) return;
    WordPart& part = parts_[std::size_t(region)];
    const auto fits = [&] {
      const std::int64_t dx = at.anchor_x - part.head.base_x, dy = at.anchor_y - part.head.base_y;
      return dx >= 0 && dx <= 255 && dy >= 0 && dy <= 255;
    };
    if (!used(region) || !fits()) open_group(region, at);
    const Splat splat = make_splat(frame_.frame.footprint, at.dx, at.dy, sample.r, sample.g, sample.b,
                                   sample.opacity, static_cast<std::uint8_t>(at.anchor_x - part.head.base_x),
                                   static_cast<std::uint8_t>(at.anchor_y - part.head.base_y));
    append(part.bytes, splat);
    ++part.head.count;
    count(region, column, 1);
  }

  /// The first base lies the kernel's reach before the region's corner, so one group holds all anchors of a
  /// region of up to 250 pixels. Further bases follow every 256 pixels.
  void open_group(int region, const Anchored& at) {
    WordPart& part = parts_[std::size_t(region)];
    if (used(region)) part.close_group();
    const PixelRect& rect = this->rect(region);
    const auto base = [](std::int64_t anchor_pixel, std::int64_t corner) {
      return static_cast<std::int32_t>(corner + ((anchor_pixel - corner) & ~std::int64_t{255}));
    };
    part.head = {region, base(at.anchor_x, rect.x0 - frame_.reach.x - 1),
                 base(at.anchor_y, rect.y0 - frame_.reach.y - 1), 0};
    part.group = part.bytes.size();
    append(part.bytes, part.head);
  }

  void append_parts(int region, std::span<const std::unique_ptr<RowBand>> bands, Bytes& payload) override {
    std::size_t open = 0;  // offset of the region's last group; 0, where the header is: none
    for (const auto& band : bands) {
      auto& self = static_cast<WordBand&>(*band);
      if (!self.used(region)) continue;
      WordPart& part = self.parts_[std::size_t(region)];
      part.close_group();
      append_part(part, payload, open);
    }
  }

  /// Bases depend on anchors alone, so a group that continues in the next band's part is joined.
  static void append_part(WordPart& part, Bytes& payload, std::size_t& open) {
    SplatGroup first;
    std::memcpy(&first, part.bytes.data(), sizeof first);
    const std::size_t joined = open != 0 && continues(payload, open, first) ? sizeof first : 0;
    const std::size_t at = payload.size() - joined;
    payload.insert(payload.end(), part.bytes.begin() + std::ptrdiff_t(joined), part.bytes.end());
    if (joined == 0 || part.group > 0) open = at + part.group;
    part.bytes.clear();
  }

  /// When `next` has the base of the group at `open`, adds its splats to that group's count.
  static bool continues(Bytes& payload, std::size_t open, const SplatGroup& next) {
    SplatGroup last;
    std::memcpy(&last, payload.data() + open, sizeof last);
    if (last.base_x != next.base_x || last.base_y != next.base_y) return false;
    last.count += next.count;
    std::memcpy(payload.data() + open, &last, sizeof last);
    return true;
  }

  std::vector<WordPart> parts_;  ///< by region
};

}  // namespace

std::unique_ptr<RowBand> make_word_band(const EncoderFrame& frame) {
  return std::make_unique<WordBand>(frame);
}

}  // namespace ringsplat
