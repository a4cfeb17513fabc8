#pragma once
#include <cstddef>
#include <string>
#include <string_view>

/// Text from outside as it may be shown: a file's bytes must not steer the terminal that a message appears
/// on.
namespace ringsplat {

/// Writes control characters other than line feeds, and bytes that are not UTF-8, as \xNN.
std::string printable(std::string_view text);

/// The first `most` characters as printable() shows them, but line feeds as \x0a, too; then "..." if there
/// are more.
std::string excerpt(std::string_view text, std::size_t most = 60);

/// Minus zero, which reads as a mistake, becomes zero.
constexpr double plain(double value) { return value == 0 ? 0.0 : value; }

}  // namespace ringsplat
