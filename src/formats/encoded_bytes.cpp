#include "formats/encoded_bytes.hpp"

#include <blosc.h>
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::size_t window_bytes = 64 * 1024;

class PlainBytes final : public EncodedBytes {
 public:
  PlainBytes(const InputFile& file, std::uint64_t begin, std::uint64_t end)
      : file_(file), begin_(begin), end_(end) {}
  void read(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset > most() || out.size() > most() - offset)
      refuse(file_.path(), "the file was cut short or its sizes are wrong",
             "its data ends at byte {}, {} more are needed", end_, out.size());
    file_.read(begin_ + offset, out);
  }
  std::uint64_t most() const override { return end_ - begin_; }

 private:
  const InputFile& file_;
  std::uint64_t begin_, end_;
};

/// Bytes that are decoded one after another, from their beginning again where earlier ones are wanted.
class BytesInOrder : public EncodedBytes {
 public:
  void read(std::uint64_t offset, std::span<std::byte> out) final {
    if (offset < position_) {
      restart();
      position_ = 0;
    }
    std::vector<std::byte> skipped(std::size_t(std::min<std::uint64_t>(offset - position_, window_bytes)));
    while (position_ < offset)
      take(
          std::span(skipped).first(std::size_t(std::min<std::uint64_t>(offset - position_, skipped.size()))));
    take(out);
  }

 protected:
  explicit BytesInOrder(const InputFile& file) : file_(file) {}

  virtual void restart() = 0;
  /// Fills the beginning of `out` with the next bytes and returns how many.
  virtual std::size_t decode(std::span<std::byte> out) = 0;

  const InputFile& file_;
  std::uint64_t position_ = 0;  ///< bytes decoded so far

 private:
  void take(std::span<std::byte> out) {
    while (!out.empty()) {
      const auto made = decode(out);
      position_ += made;
      out = out.subspan(made);
    }
  }
};

class InflatedBytes final : public BytesInOrder {
 public:
  InflatedBytes(const InputFile& file, std::uint64_t begin)
      : BytesInOrder(file), begin_(begin), file_position_(begin), window_(window_bytes) {
    constexpr int any_header = 15 + 32;  // zlib.h, inflateInit2: largest window, gzip or zlib by its header
    if (inflateInit2(&stream_, any_header) != Z_OK) throw std::bad_alloc();
  }
  ~InflatedBytes() override { inflateEnd(&stream_); }
  InflatedBytes(const InflatedBytes&) = delete;

  /// More data than voxels is no error. Decodes one more window all the same: damage mostly shows within it.
  void verify_end() override {
    std::vector<std::byte> rest(window_bytes);
    for (std::size_t made = 0; !member_ended_ && made < rest.size();) {
      const auto now = decode(std::span(rest).subspan(made));
      made += now;
      position_ += now;
    }
  }

 private:
  void restart() override {
    inflateReset(&stream_);
    file_position_ = begin_;
    stream_.avail_in = 0;
    member_ended_ = false;
  }

  /// Not beyond the end of one of several compressed streams behind each other.
  std::size_t decode(std::span<std::byte> out) override {
    if (stream_.avail_in == 0) refill();
    if (member_ended_) inflateReset(&stream_);
    const auto room = std::min<std::size_t>(out.size(), std::numeric_limits<uInt>::max());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(room);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR)
      fail_stream(stream_.msg != nullptr ? stream_.msg : "is damaged");
    member_ended_ = result == Z_STREAM_END;
    return room - stream_.avail_out;
  }

  void refill() {
    const auto got = file_.read_some(file_position_, window_);
    if (got == 0) fail_stream("ends");
    file_position_ += got;
    stream_.next_in = reinterpret_cast<Bytef*>(window_.data());
    stream_.avail_in = static_cast<uInt>(got);
  }

  [[noreturn]] void fail_stream(const char* what) const {
    refuse(file_.path(), "copy or write the file again",
           "the compressed data is cut short or damaged after {} decoded bytes ({})", position_, what);
  }

  std::uint64_t begin_, file_position_;
  bool member_ended_ = false;
  z_stream stream_{};
  std::vector<std::byte> window_;
};

/// Of characters.
class BytesInText : public BytesInOrder {
 public:
  BytesInText(const InputFile& file, std::uint64_t begin, std::uint64_t end)
      : BytesInOrder(file), begin_(begin), end_(end), text_(std::in_place, file, begin, end) {}

 protected:
  void restart() override { text_.emplace(file_, begin_, end_); }

  static constexpr const char* damaged = "the file was cut short or is damaged: copy or write it again";

  std::uint64_t begin_, end_;
  std::optional<TextReader> text_;
};

class Base64Bytes final : public BytesInText {
 public:
  using BytesInText::BytesInText;
  std::uint64_t most() const override { return (end_ - begin_) / 4 * 3 + 3; }

 private:
  static constexpr std::uint8_t blank = 64, padding = 65, strange = 66;
  static constexpr std::array<std::uint8_t, 256> values = [] {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> list{};
    list.fill(strange);
    for (std::size_t i = 0; i < alphabet.size(); ++i) list[std::size_t(alphabet[i])] = std::uint8_t(i);
    for (const char c : {' ', '\t', '\r', '\n'}) list[std::size_t(c)] = blank;
    list[std::size_t('=')] = padding;
    return list;
  }();

  void restart() override {
    BytesInText::restart();
    made_ = used_ = 0;
  }

  std::size_t decode(std::span<std::byte> out) override {
    if (used_ == made_) decode_four();
    const auto count = std::min(out.size(), made_ - used_);
    std::memcpy(out.data(), bytes_.data() + used_, count);
    used_ += count;
    return count;
  }

  /// Four letters are three bytes; two or three letters before padding are one or two.
  void decode_four() {
    std::uint32_t bits = 0;
    int letters = 0, pads = 0;
    while (letters + pads < 4) {
      const auto letter = text_->peek();
      if (!letter) fail_data("ends too early");
      text_->advance();
      const auto value = values[static_cast<unsigned char>(*letter)];
      if (value == blank) continue;
      if (value == strange || (value == padding ? letters < 2 : pads > 0)) fail_data("is no base64");
      bits = bits << 6 | (value == padding ? 0U : value);
      (value == padding ? pads : letters) += 1;
    }
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = std::byte(bits >> (16 - 8 * i) & 255U);
    made_ = std::size_t(letters - 1);
    used_ = 0;
  }

  [[noreturn]] void fail_data(const char* what) const {
    refuse(file_.path(), damaged, "its data {} after {} bytes", what, position_);
  }

  std::array<std::byte, 3> bytes_{};
  std::size_t made_ = 0, used_ = 0;
};

class HexBytes final : public BytesInText {
 public:
  using BytesInText::BytesInText;

 private:
  std::size_t decode(std::span<std::byte> out) override {
    for (auto& byte : out) {
      const auto high = digit();
      byte = std::byte(high << 4 | digit());
    }
    return out.size();
  }

  unsigned digit() {
    auto c = text_->peek();
    for (; c && std::isspace(static_cast<unsigned char>(*c)) != 0; c = text_->peek()) text_->advance();
    unsigned value = 0;
    constexpr int base = 16;
    if (!c || std::from_chars(&*c, &*c + 1, value, base).ec != std::errc())
      refuse(file_.path(), damaged, "byte {} is no hexadecimal digit", text_->position());
    text_->advance();
    return value;
  }
};

/// Writers print whole numbers as "1e+06" too.
template <class T>
std::optional<T> voxel_in(const std::string& word) {
  const auto number = number_in<double>(word);
  if (!number) return {};
  if constexpr (std::is_integral_v<T>)
    if (!(*number >= double(std::numeric_limits<T>::min()) &&
          *number <= double(std::numeric_limits<T>::max())) ||
        *number != std::trunc(*number))
      return {};
  return T(*number);
}

class BytesOfNumbers final : public BytesInText {
 public:
  BytesOfNumbers(const InputFile& file, std::uint64_t begin, std::uint64_t end, ScalarType type)
      : BytesInText(file, begin, end), type_(type) {}

 private:
  std::size_t decode(std::span<std::byte> out) override {
    visit_type(type_, [&](auto zero) {
      using T = decltype(zero);
      auto* const values = reinterpret_cast<T*>(out.data());
      for (std::size_t i = 0; i < out.size() / sizeof(T); ++i) {
        const auto word = text_->word();
        if (word.empty())
          refuse(file_.path(), "the file was cut short or its sizes are wrong",
                 "the header promises more numbers than the {} that the file holds",
                 position_ / sizeof(T) + i);
        const auto value = voxel_in<T>(word);
        if (!value)
          refuse(file_.path(), "correct the file or its type", "voxel {}, '{}', is not a number of type {}",
                 position_ / sizeof(T) + i, excerpt(word), to_string(type_));
        values[i] = *value;
      }
    });
    return out.size();
  }

  ScalarType type_;
};

}  // namespace

std::unique_ptr<EncodedBytes> encoded_bytes(const InputFile& file, Encoding encoding, std::uint64_t begin,
                                            std::uint64_t end, ScalarType type) {
  if (encoding == Encoding::raw) return std::make_unique<PlainBytes>(file, begin, end);
  if (encoding == Encoding::deflate) return std::make_unique<InflatedBytes>(file, begin);
  if (encoding == Encoding::base64) return std::make_unique<Base64Bytes>(file, begin, end);
  if (encoding == Encoding::hex) return std::make_unique<HexBytes>(file, begin, end);
  return std::make_unique<BytesOfNumbers>(file, begin, end, type);
}

bool decompress(Compressor compressor, std::span<const std::byte> in, std::span<std::byte> out) {
  const auto* const from = reinterpret_cast<const unsigned char*>(in.data());
  auto* const to = reinterpret_cast<unsigned char*>(out.data());
  constexpr std::size_t most = LZ4_MAX_INPUT_SIZE;
  std::size_t read = 0, made = out.size();
  std::uint64_t memory = 80 << 20;  // the largest dictionary that liblzma's presets have takes 65 MiB
  switch (compressor) {
    case Compressor::none:
      if (in.size() == out.size()) std::ranges::copy(in, out.begin());
      return in.size() == out.size();
    case Compressor::deflate:
      return uncompress(to, &made, from, in.size()) == Z_OK && made == out.size();
    case Compressor::lz4:
      return in.size() <= most && out.size() <= most &&
             LZ4_decompress_safe(reinterpret_cast<const char*>(from), reinterpret_cast<char*>(to),
                                 int(in.size()), int(out.size())) == int(out.size());
    case Compressor::zstd:
      return ZSTD_decompress(to, out.size(), from, in.size()) == out.size();
    case Compressor::blosc:  // by one thread, as all ranks decode
      return blosc_cbuffer_validate(from, in.size(), &made) == 0 && made == out.size() &&
             blosc_decompress_ctx(from, to, out.size(), 1) == int(out.size());
    case Compressor::lzma:
      break;
  }
  made = 0;
  return lzma_stream_buffer_decode(&memory, 0, nullptr, from, &read, in.size(), to, &made, out.size()) ==
             LZMA_OK &&
         made == out.size();
}

}  // namespace ringsplat::detail
