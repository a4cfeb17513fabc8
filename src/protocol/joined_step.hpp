#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/engine.hpp"

namespace ringsplat {

/// Begins a part of a joined payload.
struct JoinedPart {
  std::int32_t number = 0;  ///< what it is of: a slice's step of the inner engine, or one of several volumes
  std::uint32_t passes = 0;
  std::uint64_t bytes = 0;  ///< of its payload, which follows; the next part is aligned like this one
};

/// Bytes of a joined payload of `joined` bytes behind which comes one of `bytes` bytes.
std::size_t joined_with(std::size_t joined, std::size_t bytes);
/// Takes the head of a joined payload's part behind byte `at`, and moves `at` to its payload. Returns false
/// when the part is not whole.
bool take_part(std::span<const std::byte> joined, std::size_t& at, JoinedPart& part);

/// Joins several encoded steps to one, each Renderer's payloads to one.
class JoinedStep {
 public:
  /// Forgets what was added.
  void begin();
  void add(int number, EncodedStep&& step);
  /// Joins the payloads of a Renderer; true once all are joined.
  bool work();
  EncodedStep take() { return std::move(joined_); }

 private:
  /// A payload of one of the steps.
  struct Payload {
    JoinedPart head;
    Bytes body;  ///< as a message's
  };
  static Bytes join(std::vector<Payload>& payloads);
  void add_part(int number, EncodedPart&& part, std::size_t renderer);

  std::vector<std::vector<Payload>> payloads_;  ///< by Renderer
  std::size_t joined_to_ = 0;                   ///< Renderers whose payloads are joined
  EncodedStep joined_;
};

}  // namespace ringsplat
