#include "formats/encoded_bytes.hpp"

#include <blosc.h>
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <cmath>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>

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
    for (std::vector<std::byte> skipped; position_ < offset; take(skipped))
      skipped.resize(std::size_t(std::min<std::uint64_t>(offset - position_, window_bytes)));
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

  std::uint64_t begin_, end_;
  std::optional<TextReader> text_;
};

using DigitValues = std::array<std::uint8_t, 256>;
constexpr std::uint8_t no_digit = 255;

/// By character, of digits that begin with 0 again after every `base` of them.
constexpr DigitValues values_of(std::string_view digits, std::size_t base) {
  DigitValues values{};
  values.fill(no_digit);
  for (std::size_t i = 0; i < digits.size(); ++i) values[std::size_t(digits[i])] = std::uint8_t(i % base);
  return values;
}

constexpr DigitValues of_hex = values_of("0123456789abcdef0123456789ABCDEF", 16),
                      of_base64 =
                          values_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/", 64);

/// Hexadecimal digits, of which two are a byte, or base64's, of which four are three bytes, and two or three
/// before padding one or two.
class BytesOfDigits final : public BytesInText {
 public:
  BytesOfDigits(const InputFile& file, std::uint64_t begin, std::uint64_t end, bool hex)
      : BytesInText(file, begin, end), hex_(hex) {}
  std::uint64_t most() const override { return (end_ - begin_) / 4 * 3 + 3; }

 private:
  void restart() override {
    BytesInText::restart();
    left_ = 0;
  }

  std::size_t decode(std::span<std::byte> out) override {
    if (left_ == 0) take_group();
    const auto count = std::min(out.size(), left_);
    for (auto& byte : out.first(count)) byte = std::byte(group_ >> 8 * --left_ & 255U);
    return count;
  }

  void take_group() {
    const int digits = hex_ ? 2 : 4, bits = hex_ ? 4 : 6;
    int pads = 0;
    for (int i = 0; i < digits; ++i) {
      const auto c = next();
      if (!c) refuse(file_.path(), again, "its data ends too early, at byte {}", text_->position());
      const auto value = (hex_ ? of_hex : of_base64)[static_cast<unsigned char>(*c)];
      if (!hex_ && c == '=' && i > 1)
        ++pads;
      else if (value == no_digit || pads > 0)
        refuse(file_.path(), again, "byte {} is no {}", text_->position() - 1,
               hex_ ? "hexadecimal digit" : "base64");
      else
        group_ = group_ << bits | value;
    }
    left_ = std::size_t((digits - pads) * bits / 8);
    group_ >>= (digits - pads) * bits % 8;
  }

  /// The next character that is no blank.
  std::optional<char> next() {
    auto c = text_->peek();
    for (; c && std::isspace(static_cast<unsigned char>(*c)) != 0; c = text_->peek()) text_->advance();
    if (c) text_->advance();
    return c;
  }

  static constexpr const char* again = "the file was cut short or is damaged: copy or write it again";
  bool hex_;
  std::uint32_t group_ = 0;
  std::size_t left_ = 0;  ///< bytes of the group
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
  if (encoding == Encoding::base64 || encoding == Encoding::hex)
    return std::make_unique<BytesOfDigits>(file, begin, end, encoding == Encoding::hex);
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
