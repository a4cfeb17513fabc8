#include "formats/encoded_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "base/byte_stream.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

class PlainBytes final : public EncodedBytes {
 public:
  PlainBytes(const InputFile& file, std::uint64_t begin, std::uint64_t end)
      : file_(file), begin_(begin), end_(end) {}
  void read(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset > most() || out.size() > most() - offset)
      throw InputError(fmt::format("{}: its data ends at byte {}, {} more are needed", file_.path().string(),
                                   end_, out.size()),
                       "the file was cut short or its sizes are wrong");
    file_.read(begin_ + offset, out);
  }
  std::uint64_t most() const override { return end_ - begin_; }

 private:
  const InputFile& file_;
  std::uint64_t begin_, end_;
};

constexpr std::uint8_t blank = 64, padding = 65, strange = 66;

constexpr std::array<std::uint8_t, 256> base64_values = [] {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::uint8_t, 256> values{};
  values.fill(strange);
  for (std::size_t i = 0; i < alphabet.size(); ++i) values[std::size_t(alphabet[i])] = std::uint8_t(i);
  for (const char c : {' ', '\t', '\r', '\n'}) values[std::size_t(c)] = blank;
  values[std::size_t('=')] = padding;
  return values;
}();

/// Decodes in order.
class Base64Bytes final : public EncodedBytes {
 public:
  Base64Bytes(const InputFile& file, std::uint64_t begin, std::uint64_t end)
      : file_(file), begin_(begin), end_(end), window_(64 * 1024) {
    restart();
  }

  void read(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset < position_) restart();
    std::array<std::byte, 4096> skipped{};
    while (position_ < offset)
      take(
          std::span(skipped).first(std::size_t(std::min<std::uint64_t>(offset - position_, skipped.size()))));
    take(out);
  }
  std::uint64_t most() const override { return (end_ - begin_) / 4 * 3 + 3; }

 private:
  void restart() {
    next_ = begin_;
    at_ = got_ = 0;
    position_ = 0;
    made_ = used_ = 0;
  }

  void take(std::span<std::byte> out) {
    while (!out.empty()) {
      if (used_ == made_) decode_four();
      const auto count = std::min(out.size(), made_ - used_);
      std::memcpy(out.data(), bytes_.data() + used_, count);
      used_ += count;
      position_ += count;
      out = out.subspan(count);
    }
  }

  /// Four letters are three bytes; two or three letters before padding are one or two.
  void decode_four() {
    std::uint32_t bits = 0;
    int letters = 0, pads = 0;
    while (letters + pads < 4) {
      const auto value = next_letter();
      if (value == blank) continue;
      if (value == strange || (value == padding ? letters < 2 : pads > 0)) fail("is no base64");
      bits = bits << 6 | (value == padding ? 0U : value);
      (value == padding ? pads : letters) += 1;
    }
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = std::byte(bits >> (16 - 8 * i) & 255U);
    made_ = std::size_t(letters - 1);
    used_ = 0;
  }

  std::uint8_t next_letter() {
    if (at_ == got_) {
      const auto wanted = std::min<std::uint64_t>(window_.size(), end_ - next_);
      got_ = file_.read_some(next_, std::span(window_).first(std::size_t(wanted)));
      at_ = 0;
      next_ += got_;
      if (got_ == 0) fail("ends too early");
    }
    return base64_values[std::to_integer<std::size_t>(window_[at_++])];
  }

  [[noreturn]] void fail(const char* what) const {
    throw InputError(fmt::format("{}: its data {} after {} bytes", file_.path().string(), what, position_),
                     "the file was cut short or is damaged: copy or write it again");
  }

  const InputFile& file_;
  std::uint64_t begin_, end_, next_ = 0;
  std::vector<std::byte> window_;
  std::size_t at_ = 0, got_ = 0;
  std::uint64_t position_ = 0;
  std::array<std::byte, 3> bytes_{};
  std::size_t made_ = 0, used_ = 0;
};

}  // namespace

std::unique_ptr<EncodedBytes> plain_bytes(const InputFile& file, std::uint64_t begin, std::uint64_t end) {
  return std::make_unique<PlainBytes>(file, begin, end);
}

std::unique_ptr<EncodedBytes> base64_bytes(const InputFile& file, std::uint64_t begin, std::uint64_t end) {
  return std::make_unique<Base64Bytes>(file, begin, end);
}

}  // namespace ringsplat::detail
