#include "serve/jpeg.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {

JpegEncoder::JpegEncoder() : handle_(tjInitCompress()) {
  if (handle_ == nullptr) throw RunError(fmt::format("no JPEG encoder: {}", tjGetErrorStr2(nullptr)));
}

JpegEncoder::~JpegEncoder() {
  tjFree(bytes_);
  tjDestroy(handle_);
}

std::span<const std::uint8_t> JpegEncoder::encode(std::span<const std::uint8_t> rgb, int width, int height,
                                                  JpegQuality quality) {
  const bool moving = quality == JpegQuality::moving;
  unsigned long size = capacity_;
  if (tjCompress2(handle_, rgb.data(), width, 0, height, TJPF_RGB, &bytes_, &size,
                  moving ? TJSAMP_420 : TJSAMP_444, moving ? 80 : 95, 0) != 0)
    throw RunError(fmt::format("a picture could not be encoded: {}", tjGetErrorStr2(handle_)));
  capacity_ = std::max(capacity_, size);
  return {bytes_, size};
}

}  // namespace ringsplat::serve
