#pragma once
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/input_file.hpp"

namespace ringsplat::detail {

/// Decodes a gzip or zlib stream that begins at a byte of a file, in order, through a small window.
/// The file must outlive the stream.
class InflateStream {
 public:
  InflateStream(const InputFile& file, std::uint64_t offset);
  ~InflateStream();
  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;

  std::uint64_t position() const { return position_; }  ///< bytes decoded so far
  /// Fills `out` with the next bytes. Throws InputError when the stream is damaged or ends too early.
  void read(std::span<std::byte> out);
  void skip(std::uint64_t bytes);
  /// Call it after the last byte wanted. If the stream ends there, its checksum must be right.
  void verify_end();

 private:
  bool refill();
  /// Decodes up to out.size() bytes, not beyond a member's end; returns how many.
  std::size_t decode(std::span<std::byte> out);
  void next_member();
  [[noreturn]] void fail(const char* what) const;

  const InputFile& file_;
  std::uint64_t file_position_;
  std::uint64_t position_ = 0;
  bool member_ended_ = false;
  z_stream stream_{};
  std::vector<std::byte> window_;
};

}  // namespace ringsplat::detail
