#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// Exact bytes and back, for ranks of one build. decode_frame_spec() throws RunError when they are no
/// FrameSpec; check() tells whether its values make sense. `volume`: the number of the one it is of, below
/// 64.
Bytes encode(const FrameSpec& spec, std::size_t volume = 0);
FrameSpec decode_frame_spec(std::span<const std::byte> bytes);
std::size_t volume_of(std::span<const std::byte> bytes);
/// An encoded frame's method, with its usual options.
Method method_of(std::span<const std::byte> bytes);
/// As JSON text, for --stats and image metadata.
std::string to_json_text(const FrameSpec& spec);

}  // namespace ringsplat
