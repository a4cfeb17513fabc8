#include "formats/deflate_stream.hpp"

#include <algorithm>
#include <limits>
#include <new>

namespace ringsplat::detail {
namespace {
constexpr std::size_t window_bytes = 64 * 1024;
constexpr int gzip_header = 15 + 16;  // zlib.h, deflateInit2: largest window, gzip
constexpr int usual_memory = 8;
}  // namespace

DeflateStream::DeflateStream(OutputFile& file) : file_(file), window_(window_bytes) {
  if (deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_header, usual_memory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
}

DeflateStream::~DeflateStream() { deflateEnd(&stream_); }

void DeflateStream::encode(int flush) {
  do {
    stream_.next_out = reinterpret_cast<Bytef*>(window_.data());
    stream_.avail_out = static_cast<uInt>(window_.size());
    deflate(&stream_, flush);
    file_.write(std::span(window_).first(window_.size() - stream_.avail_out));
  } while (stream_.avail_out == 0);
}

void DeflateStream::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto part = std::min<std::size_t>(bytes.size(), std::numeric_limits<uInt>::max());
    // zlib.h declares what it only reads without const.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
    stream_.avail_in = static_cast<uInt>(part);
    encode(Z_NO_FLUSH);
    bytes = bytes.subspan(part);
  }
}

void DeflateStream::finish() { encode(Z_FINISH); }

}  // namespace ringsplat::detail
