#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/input_file.hpp"

namespace ringsplat::detail {

/// Bytes that a file holds as they are or in an encoding.
class EncodedBytes {
 public:
  virtual ~EncodedBytes() = default;
  /// Fills `out` with the bytes from `offset` on. Throws InputError when there are fewer.
  virtual void read(std::uint64_t offset, std::span<std::byte> out) = 0;
  /// More than there can be.
  virtual std::uint64_t most() const = 0;
};

/// Bytes [begin, end) of the file, which must outlive them.
std::unique_ptr<EncodedBytes> plain_bytes(const InputFile& file, std::uint64_t begin, std::uint64_t end);

/// What bytes [begin, end) of the file say in base64 (RFC 4648); blanks are left out, and where one text ends
/// with padding the next one follows. Cheapest in ascending order. The file must outlive it.
std::unique_ptr<EncodedBytes> base64_bytes(const InputFile& file, std::uint64_t begin, std::uint64_t end);

}  // namespace ringsplat::detail
