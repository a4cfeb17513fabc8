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

  bool next(std::uint32_t most, SplatChunk& chunk) override {
    while (left_ == 0) {
      if (!take(body_, at_, group_)) return false;
      left_ = group_.count;
    }
    const std::uint32_t count = std::min(most, left_);
    chunk = {group_.region, group_.base_x, group_.base_y, body_.subspan(at_, count * sizeof(Splat))};
    at_ += count * sizeof(Splat);
    left_ -= count;
    return true;
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
