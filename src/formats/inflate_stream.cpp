#include "formats/inflate_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <new>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {
constexpr std::size_t window_bytes = 64 * 1024;
constexpr int any_header = 15 + 32;  // zlib.h, inflateInit2: largest window, gzip or zlib by its header
}  // namespace

InflateStream::InflateStream(const InputFile& file, std::uint64_t offset)
    : file_(file), file_position_(offset), window_(window_bytes) {
  if (inflateInit2(&stream_, any_header) != Z_OK) throw std::bad_alloc();
}

InflateStream::~InflateStream() { inflateEnd(&stream_); }

bool InflateStream::refill() {
  const auto got = file_.read_some(file_position_, window_);
  file_position_ += got;
  stream_.next_in = reinterpret_cast<Bytef*>(window_.data());
  stream_.avail_in = static_cast<uInt>(got);
  return got > 0;
}

void InflateStream::next_member() {
  if (stream_.avail_in == 0 && !refill()) fail("ends");
  inflateReset(&stream_);
  member_ended_ = false;
}

std::size_t InflateStream::decode(std::span<std::byte> out) {
  if (stream_.avail_in == 0 && !refill()) fail("ends");
  const auto room = std::min<std::size_t>(out.size(), std::numeric_limits<uInt>::max());
  stream_.next_out = reinterpret_cast<Bytef*>(out.data());
  stream_.avail_out = static_cast<uInt>(room);
  const int result = inflate(&stream_, Z_NO_FLUSH);
  if (result == Z_STREAM_END)
    member_ended_ = true;
  else if (result != Z_OK && result != Z_BUF_ERROR)
    fail(stream_.msg != nullptr ? stream_.msg : "is damaged");
  const auto made = room - stream_.avail_out;
  position_ += made;
  return made;
}

void InflateStream::read(std::span<std::byte> out) {
  while (!out.empty()) {
    if (member_ended_) next_member();
    out = out.subspan(decode(out));
  }
}

void InflateStream::skip(std::uint64_t bytes) {
  std::vector<std::byte> scratch(std::size_t(std::min<std::uint64_t>(bytes, window_bytes)));
  while (bytes > 0) {
    const auto part = std::size_t(std::min<std::uint64_t>(bytes, scratch.size()));
    read(std::span(scratch).first(part));
    bytes -= part;
  }
}

void InflateStream::verify_end() {
  // More data than voxels is no error. Decodes one more window all the same: damage mostly shows within it.
  std::vector<std::byte> rest(window_bytes);
  std::size_t made = 0;
  while (!member_ended_ && made < rest.size()) made += decode(std::span(rest).subspan(made));
}

void InflateStream::fail(const char* what) const {
  throw InputError(fmt::format("{}: the compressed data is cut short or damaged after {} decoded bytes ({})",
                               file_.path().string(), position_, what),
                   "copy or write the file again");
}

}  // namespace ringsplat::detail
