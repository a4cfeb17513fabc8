#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// Exact bytes and back, for ranks of one build. decode_frame_spec() throws RunError when they are no
/// FrameSpec; check() tells whether its values make sense.
Bytes encode(const FrameSpec& spec);
FrameSpec decode_frame_spec(std::span<const std::byte> bytes);

/// A frame of one of the volumes that are rendered together: the scene's own, 0, or one of its others.
struct FrameOfVolume {
  std::size_t volume = 0;
  FrameSpec spec;
};
/// A frame as it is announced: of a volume, or of several that are drawn as one. decode_frames() throws
/// RunError when the bytes are none.
Bytes encode(const std::vector<FrameOfVolume>& frames);
std::vector<FrameOfVolume> decode_frames(std::span<const std::byte> bytes);
/// The method of an announced frame, with its usual options.
Method method_of(std::span<const std::byte> bytes);
/// For --stats and image metadata; names are whatever bytes they are.
nlohmann::json to_json(const FrameSpec& spec);
nlohmann::json to_json(const TransferFunction& transfer_function);

}  // namespace ringsplat
