#pragma once
#include <zlib.h>

#include <cstddef>
#include <span>
#include <vector>

#include "base/output_file.hpp"

namespace ringsplat::detail {

/// Appends one gzip stream to a file, which must outlive it.
class DeflateStream {
 public:
  explicit DeflateStream(OutputFile& file);
  ~DeflateStream();
  DeflateStream(const DeflateStream&) = delete;
  DeflateStream& operator=(const DeflateStream&) = delete;

  /// Throws RunError as OutputFile does.
  void write(std::span<const std::byte> bytes);
  /// The stream's end and checksum.
  void finish();

 private:
  void encode(int flush);

  OutputFile& file_;
  z_stream stream_{};
  std::vector<std::byte> window_;
};

}  // namespace ringsplat::detail
