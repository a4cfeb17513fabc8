#include "formats/inflate_all.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <new>
#include <span>
#include <vector>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

void inflate_all(const InputFile& file, std::uint64_t offset, MemoryFile& out) {
  constexpr std::size_t window_bytes = 64 * 1024;
  constexpr int no_header = -15;  // zlib.h, inflateInit2
  z_stream stream{};
  if (inflateInit2(&stream, no_header) != Z_OK) throw std::bad_alloc();
  struct End {
    z_stream& stream;
    ~End() { inflateEnd(&stream); }
  } const end{stream};
  std::vector<std::byte> in(window_bytes), decoded(window_bytes);
  for (int result = Z_OK; result != Z_STREAM_END;) {
    if (stream.avail_in == 0) {
      stream.avail_in = static_cast<uInt>(file.read_some(offset, in));
      stream.next_in = reinterpret_cast<Bytef*>(in.data());
      offset += stream.avail_in;
    }
    const bool ended = stream.avail_in == 0;
    stream.next_out = reinterpret_cast<Bytef*>(decoded.data());
    stream.avail_out = window_bytes;
    result = inflate(&stream, Z_NO_FLUSH);
    if ((result != Z_OK && result != Z_STREAM_END) || (ended && result != Z_STREAM_END))
      throw InputError(fmt::format("{}: the compressed data is cut short or damaged", file.path().string()),
                       "copy the file again");
    out.append(std::span(decoded).first(window_bytes - stream.avail_out));
  }
}

}  // namespace ringsplat::detail
