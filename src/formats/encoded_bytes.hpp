#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/input_file.hpp"
#include "formats/text_reader.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

enum class Encoding : std::uint32_t {
  raw,
  deflate,  ///< gzip or zlib, by its header
  base64,   ///< RFC 4648; blanks are left out, and where one text ends with padding the next one follows
  hex,      ///< two digits a byte, with or without blanks between them
  text      ///< numbers between blanks and commas, as voxels of a type in the machine's byte order
};

/// Bytes that a file holds as they are or in an encoding.
class EncodedBytes {
 public:
  virtual ~EncodedBytes() = default;
  /// Fills `out` with the bytes from `offset` on, cheapest in ascending order. Throws InputError when there
  /// are fewer, and for damaged ones. Of text whole numbers.
  virtual void read(std::uint64_t offset, std::span<std::byte> out) = 0;
  /// More than there can be; of compressed bytes and text that is not known.
  virtual std::uint64_t most() const { return file_end; }
  /// Call it after the last byte wanted: where that is where they end, a checksum behind must be right.
  virtual void verify_end() {}
};

/// What bytes [begin, end) of the file hold; `type`: of text's numbers. The file must outlive them.
std::unique_ptr<EncodedBytes> encoded_bytes(const InputFile& file, Encoding encoding, std::uint64_t begin,
                                            std::uint64_t end = file_end,
                                            ScalarType type = ScalarType::uint8);

/// Of blocks that are compressed by themselves.
enum class Compressor {
  none,
  deflate,  ///< with zlib's header
  lz4,      ///< one block without any frame
  lzma,
  zstd,
  blosc  ///< c-blosc 1, by its header
};

/// False unless `in` decodes to exactly `out`.
bool decompress(Compressor compressor, std::span<const std::byte> in, std::span<std::byte> out);

}  // namespace ringsplat::detail
