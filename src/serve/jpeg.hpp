#pragma once
#include <cstdint>
#include <span>

namespace ringsplat::serve {

enum class JpegQuality { moving, at_rest };

/// sRGB pixels, rows from the top, three bytes each, as a JPEG: quality 80 with chroma at half size while
/// moving, 95 with all of it at rest. Throws RunError when there is no memory. For one thread at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  /// The encoder's until the next call.
  std::span<const std::uint8_t> encode(std::span<const std::uint8_t> rgb, int width, int height,
                                       JpegQuality quality);

 private:
  void* handle_;
  unsigned char* bytes_ = nullptr;
  unsigned long capacity_ = 0;
};

}  // namespace ringsplat::serve
