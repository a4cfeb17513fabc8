#pragma once
#include <cstddef>
#include <cstdint>

namespace ringsplat {

/// Bytes at the begin of a message, header included, that have content where a payload only counts.
inline constexpr std::size_t counted_bytes = 96;

/// Stands for Header::magic on such a message's way between simulated ranks, which then need not move the
/// rest through this machine's memory: a large volume's frame has hundreds of gigabytes.
inline constexpr std::uint32_t counted_magic = 0x43505352;  // "RSPC"

}  // namespace ringsplat
