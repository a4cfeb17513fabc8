#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "protocol/engine.hpp"

namespace ringsplat {

/// Begins a slice's part of a joined payload.
struct BundlePart {
  std::int32_t slice_step = 0;  ///< the slice's step of the inner engine
  std::uint32_t passes = 0;
  std::uint64_t bytes = 0;  ///< of the slice's payload, which follows; the next part is aligned like this one
};

/// Bytes of a joined payload of `joined` bytes behind which comes a slice's payload of `bytes` bytes.
std::size_t joined_with(std::size_t joined, std::size_t bytes);
/// Takes the head of a joined payload's part behind byte `at`, and moves `at` to the slice's payload. Returns
/// false when the part is not whole.
bool take_part(std::span<const std::byte> joined, std::size_t& at, BundlePart& part);

/// An engine whose steps are bundles: up to `bundle` consecutive slices, all of one GP, which are the steps
/// of `inner`. A Renderer's payloads of a bundle's slices are joined to one, so that a token passes the
/// bundle as it passes a slice, by payload, accept and token. Bundles are those of the volume: where a frame
/// shows a part of it, its first and its last bundle may be shorter. Painters draw slice by slice, so no bit
/// depends on `bundle`.
std::unique_ptr<Engine> make_bundle_engine(std::unique_ptr<Engine> inner, int bundle);

}  // namespace ringsplat
