#pragma once
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>

#include "base/fingerprint.hpp"

namespace ringsplat {

/// A fingerprint of how things lie in messages.
class WireHash {
 public:
  void number(std::uint64_t value) { hash_.add(fmt::format("{} ", value)); }
  void text(const std::string& text) { hash_.add(text + '\n'); }
  void bytes(std::span<const std::byte> bytes) {
    number(bytes.size());
    hash_.add(bytes);
  }

  /// Where each member lies. One that is forgotten here does not compile: all fill the struct, with `Padding`
  /// bytes.
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

  /// The numbers by which choices travel.
  template <class Enum>
  void order(std::initializer_list<Enum> choices) {
    for (const Enum choice : choices) number(std::uint64_t(choice));
  }

  std::uint64_t value() const { return hash_.value(); }

 private:
  Fingerprint hash_;
};

}  // namespace ringsplat
