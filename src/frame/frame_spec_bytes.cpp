#include "frame/frame_spec_bytes.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <variant>

#include "base/archive.hpp"
#include "frame/frame_fields.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Reads the method's index among Method's alternatives.
void take_method(FromBytes& archive, Method& how) {
  std::uint8_t index = 0;
  archive(index);
  const auto take_it = [&]<std::size_t... I>(std::index_sequence<I...>) {
    return ((index == I && (how.emplace<I>(), true)) || ...);
  };
  if (!archive.ok() || !take_it(std::make_index_sequence<std::variant_size_v<Method>>()))
    throw RunError("a frame announcement cannot be read", "all ranks must run the same build");
}

}  // namespace

Bytes encode(const FrameSpec& spec) { return to_bytes(std::uint8_t(spec.how.index()), spec); }

std::string method_of(std::span<const std::byte> bytes) {
  Method how;
  FromBytes archive(bytes);
  take_method(archive, how);
  return name(how);
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  FrameSpec spec;
  FromBytes archive(bytes);
  take_method(archive, spec.how);
  archive(spec);
  if (!archive.ok() || !archive.at_end())
    throw RunError("a frame announcement cannot be read", "all ranks must run the same build");
  return spec;
}

}  // namespace ringsplat
