#include "serve/page_encoding.hpp"

#include <zlib.h>

#include <charconv>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {
namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    unsigned group = 0;
    for (std::size_t at = k; at < k + 3; ++at)
      group = group << 8 | (at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0U);
    for (unsigned digit = 0; digit < 4; ++digit)
      text += k + digit > bytes.size() ? '=' : digits[group >> (18 - 6 * digit) & 63];
  }
  return text;
}

}  // namespace

std::string policy_source(std::string_view hexadecimal) {
  std::string bytes;
  for (std::size_t k = 0; k + 1 < hexadecimal.size(); k += 2) {
    unsigned byte = 0;
    std::from_chars(&hexadecimal[k], &hexadecimal[k] + 2, byte, 16);
    bytes += static_cast<char>(byte);
  }
  return "'sha256-" + base64(bytes) + "'";
}

std::string gzipped(std::string_view bytes) {
  constexpr int gzip_header = 15 + 16, usual_memory = 8;  // zlib.h, deflateInit2; without a time
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip_header, usual_memory, Z_DEFAULT_STRATEGY) !=
      Z_OK)
    throw RunError("the page cannot be compressed");
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int ended = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (ended != Z_STREAM_END) throw RunError("the page cannot be compressed");
  return out;
}

}  // namespace ringsplat::serve
