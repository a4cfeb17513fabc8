#include <fmt/format.h>

#include <algorithm>

#include "node/payload_reader.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/splat/splat.hpp"

namespace ringsplat {
namespace {

class WordReader final : public PayloadReader {
 public:
  void begin(int, std::span<const std::byte> body, const std::function<bool(int)>& owned) override {
    body_ = body;
    at_ = left_ = 0;
    int last = 0;
    for (std::size_t at = 0; at < body.size();) {
      SplatGroup group;
      const bool whole = take(body, at, group);
      if (!whole || group.region < last || !owned(group.region) || (body.size() - at) / sizeof(Splat) < group.count)
        throw RunError(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at),
                       "all ranks must run the same build");
      last = group.region;
      at += group.count * sizeof(Splat);
    }
  }

  std::optional<int> region() override {
    while (left_ == 0) {
      if (!take(body_, at_, group_)) return {};
      left_ = group_.count;
    }
    return group_.region;
  }

  DrawCounts draw(RegionPainter& painter, std::uint32_t most) override {
    const std::uint32_t count = std::min(most, left_);
    const auto splats = body_.subspan(at_, count * sizeof(Splat));
    at_ += splats.size();
    left_ -= count;
    return painter.draw(group_.base_x, group_.base_y, splats);
  }

 private:
  std::span<const std::byte> body_;
  std::size_t at_ = 0;
  SplatGroup group_{};
  std::uint32_t left_ = 0;  ///< splats of the group
};

}  // namespace

std::unique_ptr<PayloadReader> make_word_reader() { return std::make_unique<WordReader>(); }

}  // namespace ringsplat
