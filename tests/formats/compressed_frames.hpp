#pragma once
// Frames of compressed pixels, written byte by byte.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "formats/files.hpp"

namespace files {

/// A frame of run lengths (PS3.5, annex G) of 16-bit pixels: the high bytes, then the low ones. Runs and
/// literals both occur.
inline std::string rle_frame(const std::string& pixels) {
  const auto packed = [&](std::size_t first) {
    std::string out, plane;
    for (std::size_t i = first; i < pixels.size(); i += 2) plane += pixels[i];
    for (std::size_t at = 0; at < plane.size();) {
      std::size_t run = 1;
      while (at + run < plane.size() && run < 128 && plane[at + run] == plane[at]) ++run;
      out += run > 1 ? char(257 - int(run)) : char(0);
      out += plane[at];
      at += run;
    }
    return out.size() % 2 == 0 ? out : out + char(-128);
  };
  const auto high = packed(1), low = packed(0);
  std::string header =
      bytes_of(std::uint32_t(2)) + bytes_of(std::uint32_t(64)) + bytes_of(std::uint32_t(64 + high.size()));
  header.resize(64, '\0');
  return header + high + low;
}

class BitWriter {
 public:
  void put(unsigned value, int bits) {
    for (int i = bits - 1; i >= 0; --i) {
      byte_ = byte_ << 1 | (value >> i & 1);
      if (++filled_ < 8) continue;
      out_ += char(byte_);
      if (byte_ == 0xFF) out_ += '\0';
      byte_ = 0;
      filled_ = 0;
    }
  }
  std::string finish() {
    while (filled_ != 0) put(1, 1);
    return out_;
  }

 private:
  std::string out_;
  unsigned byte_ = 0;
  int filled_ = 0;
};

inline std::string big16(int value) { return bytes_of(std::uint16_t(value), true); }

/// A frame of lossless JPEG (ITU-T T.81, annex H, predictor 1) of pixels of up to 16 bits, row by row. All
/// Huffman codes have five bits.
inline std::string lossless_jpeg_frame(const std::vector<std::uint16_t>& pixels, int width, int height,
                                       int precision) {
  std::string out = "\xFF\xD8\xFF\xC3" + big16(11) + char(precision) + big16(height) + big16(width) +
                    std::string("\1\1\x11\0", 4) + "\xFF\xC4" + big16(2 + 17 + 17) + std::string(1, '\0');
  for (int length = 1; length <= 16; ++length) out += char(length == 5 ? 17 : 0);
  for (int category = 0; category <= 16; ++category) out += char(category);
  out += "\xFF\xDA" + big16(8) + std::string("\1\1\0\1\0\0", 6);
  BitWriter bits;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto at = std::size_t(y * width + x);
      const int predicted = x > 0   ? pixels[at - 1]
                            : y > 0 ? pixels[at - std::size_t(width)]
                                    : 1 << (precision - 1);
      const int difference = std::int16_t(std::uint16_t(pixels[at] - predicted));
      int category = 0;
      while (std::abs(difference) >> category != 0) ++category;
      bits.put(unsigned(category), 5);
      if (category < 16) bits.put(unsigned(difference > 0 ? difference : difference - 1), category);
    }
  return out + bits.finish() + "\xFF\xD9";
}

/// Of 16-bit pixels in little endian.
inline std::string lossless_jpeg_frame(const std::string& pixels, int precision = 16) {
  std::vector<std::uint16_t> values(pixels.size() / 2);
  std::memcpy(values.data(), pixels.data(), pixels.size());
  return lossless_jpeg_frame(values, nx, ny, precision);
}

}  // namespace files
