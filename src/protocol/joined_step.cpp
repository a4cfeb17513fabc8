#include "protocol/joined_step.hpp"

#include <algorithm>
#include <utility>

#include "base/byte_stream.hpp"
#include "net/message.hpp"

namespace ringsplat {
namespace {

/// Parts begin at multiples of this, as payloads do in messages.
constexpr std::size_t alignment = 16;
static_assert(sizeof(JoinedPart) == alignment && sizeof(Header) % alignment == 0);

std::size_t padding(std::size_t at) { return (alignment - at % alignment) % alignment; }

}  // namespace

std::size_t joined_with(std::size_t joined, std::size_t bytes) {
  return joined + padding(joined) + sizeof(JoinedPart) + bytes;
}

bool take_part(std::span<const std::byte> joined, std::size_t& at, JoinedPart& part) {
  at += padding(at);
  return take(joined, at, part) && part.bytes <= joined.size() - at;
}

/// Empties `payloads`.
Bytes JoinedStep::join(std::vector<Payload>& payloads) {
  std::size_t bytes = 0;
  for (const Payload& payload : payloads) bytes = joined_with(bytes, payload.head.bytes);
  Bytes body = Message::body_buffer();
  body.reserve(body.size() + bytes);
  for (Payload& payload : payloads) {
    body.insert(body.end(), padding(body.size()), std::byte{0});
    append(body, payload.head);
    body.insert(body.end(), payload.body.begin() + sizeof(Header), payload.body.end());
    payload.body = {};
  }
  payloads.clear();
  return body;
}

void JoinedStep::begin() {
  payloads_.clear();
  joined_to_ = 0;
  joined_ = {};
  joined_.slices = 0;
}

void JoinedStep::add(int number, EncodedStep&& step) {
  payloads_.resize(step.parts.size());
  joined_.parts.resize(step.parts.size());
  for (std::size_t r = 0; r < step.parts.size(); ++r)
    if (!step.parts[r].payload.empty()) add_part(number, std::move(step.parts[r]), r);
  joined_.counts.voxels += step.counts.voxels;
  joined_.counts.visible += step.counts.visible;
  joined_.counts.outside += step.counts.outside;
  joined_.counts.blocks += step.counts.blocks;
  joined_.slices += step.slices;
}

void JoinedStep::add_part(int number, EncodedPart&& part, std::size_t renderer) {
  EncodedPart& all = joined_.parts[renderer];
  all.items += part.items;
  all.kept += part.kept;
  all.passes += part.passes;
  all.tiles.insert(all.tiles.end(), part.tiles.begin(), part.tiles.end());
  const std::uint64_t bytes = Message::body_size(part.payload);
  payloads_[renderer].push_back({{number, part.passes, bytes}, std::move(part.payload)});
}

bool JoinedStep::work() {
  while (joined_to_ < payloads_.size() && payloads_[joined_to_].empty()) ++joined_to_;
  if (joined_to_ == payloads_.size()) return true;
  EncodedPart& all = joined_.parts[joined_to_];
  all.payload = join(payloads_[joined_to_]);
  std::ranges::sort(all.tiles);
  all.tiles.erase(std::unique(all.tiles.begin(), all.tiles.end()), all.tiles.end());
  return ++joined_to_ == payloads_.size();
}

}  // namespace ringsplat
