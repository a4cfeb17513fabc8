#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>

#include "base/fingerprint.hpp"

namespace ringsplat {

/// A hash of how values lie in messages.
class WireHash {
 public:
  void number(std::uint64_t value) { hash_.add(fmt::format("{} ", value)); }
  void text(const std::string& text) { hash_.add(text + '\n'); }

  /// Adds each member's offset. Forgetting a member does not compile: the members and `Padding` bytes must
  /// fill the struct.
  template <std::size_t Padding = 0, class Struct, class... Members>
  void layout(Members Struct::*... members) {
    static_assert((sizeof(Members) + ...) + Padding == sizeof(Struct), "name every member");
    const Struct sample{};
    const auto* begin = reinterpret_cast<const std::byte*>(&sample);
    const auto one = [&](const auto& member) {
      number(std::uint64_t(reinterpret_cast<const std::byte*>(&member) - begin));
      number(sizeof member);
    };
    (one(sample.*members), ...);
    number(sizeof(Struct));
  }

  /// Adds the numbers that encode a choice.
  template <class Enum>
  void order(std::initializer_list<Enum> choices) {
    for (const Enum choice : choices) number(std::uint64_t(choice));
  }

  std::uint64_t value() const { return hash_.value(); }

 private:
  Fingerprint hash_;
};

}  // namespace ringsplat
