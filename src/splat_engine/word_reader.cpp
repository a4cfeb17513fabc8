#include <fmt/format.h>

#include <algorithm>

#include "base/byte_stream.hpp"
#include "ringsplat/base/error.hpp"
#include "splat/splat.hpp"
#include "splat/splat_sum.hpp"
#include "splat_engine/payload_reader.hpp"

namespace ringsplat {
namespace {

class WordReader final : public PayloadReader {
 public:
  WordReader(const SplatFrame& frame, const FrameKernel& kernel)
      : sum_(kernel, frame.geometry.regions.rect(0)) {}

  std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                 const std::function<bool(int)>& owned) const override {
    std::vector<PayloadPart> parts;
    for (std::size_t at = 0, begin = 0; at < body.size(); begin = at) {
      SplatGroup group;
      const bool whole = take(body, at, group);
      const int last = parts.empty() ? 0 : parts.back().region;
      if (!whole || group.region < last || !owned(group.region) ||
          (body.size() - at) / sizeof(Splat) < group.count)
        throw RunError(fmt::format("a payload of {} bytes is not understood at byte {}", body.size(), at),
                       "all ranks must run the same build");
      at += group.count * sizeof(Splat);
      if (parts.empty() || group.region != last) parts.push_back({group.region, body.subspan(begin, 0)});
      PayloadPart& part = parts.back();
      part.bytes = {part.bytes.data(), part.bytes.size() + (at - begin)};
    }
    return parts;
  }

  void begin(int, const PayloadPart& part, RegionImage& image) override {
    sum_.begin(image);
    body_ = part.bytes;
    at_ = left_ = 0;
  }

  bool more() override {
    while (left_ == 0) {
      if (!take(body_, at_, group_)) return false;
      left_ = group_.count;
    }
    return true;
  }

  DrawCounts draw(std::uint32_t most) override {
    const std::uint32_t count = std::min(most, left_);
    const auto splats = body_.subspan(at_, count * sizeof(Splat));
    at_ += splats.size();
    left_ -= count;
    return sum_.draw(group_.base_x, group_.base_y, splats);
  }

  std::uint64_t composite(glm::dvec2 voxel) override { return sum_.composite(voxel); }

 private:
  SplatSum sum_;
  std::span<const std::byte> body_;  ///< of the part
  std::size_t at_ = 0;
  SplatGroup group_{};
  std::uint32_t left_ = 0;  ///< splats left in the group
};

}  // namespace

std::unique_ptr<PayloadReader> make_word_reader(const SplatFrame& frame, const FrameKernel& kernel) {
  return std::make_unique<WordReader>(frame, kernel);
}

}  // namespace ringsplat
