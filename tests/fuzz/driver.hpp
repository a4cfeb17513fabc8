#pragma once
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ringsplat/base/bytes.hpp"

namespace ringsplat::fuzz {

/// Bytes of a file or a message.
using Input = std::string;

/// A decoder under test. Whatever the input, `run` returns or throws ringsplat::Error; another exception, a
/// crash, more time or more memory than the watch allows is a finding. A result is used, and one that breaks
/// what its decoder promises throws std::logic_error.
struct Driver {
  const char* name;  ///< its files' folder too, below seeds/ and crashes/
  void (*run)(std::span<const std::byte> input);
  std::vector<Input> (*seeds)();
  std::vector<std::string_view> words;  ///< that its texts are made of
  int short_inputs;                     ///< of the run that is a test: about half a second's worth
};

const std::vector<Driver>& drivers();
std::vector<Driver> volume_drivers();
std::vector<Driver> text_drivers();
std::vector<Driver> message_drivers();
std::vector<Driver> rank_drivers();

/// A folder for the files that drivers read, gone at the end of the process that asked for it first.
const std::filesystem::path& scratch();

inline std::span<const std::byte> bytes_of_input(std::string_view input) {
  return std::as_bytes(std::span(input));
}
inline std::string_view text_of(std::span<const std::byte> input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}
/// A copy at its own address, so that reading beyond its end is noticed; aligned as messages are.
inline Bytes copy_of(std::span<const std::byte> input) { return {input.begin(), input.end()}; }

/// Takes its first byte off an input, 0 when there is none: what a driver chooses by.
inline unsigned take_choice(std::span<const std::byte>& input) {
  if (input.empty()) return 0;
  const auto choice = std::to_integer<unsigned>(input.front());
  input = input.subspan(1);
  return choice;
}

/// Inputs of several parts, as drivers of whole exchanges take them: each behind its length in four bytes.
void append_part(Input& input, std::span<const std::byte> part);
/// The next part; of one that is cut short, what is there. False at the end.
bool take_part(std::span<const std::byte>& input, std::span<const std::byte>& part);

}  // namespace ringsplat::fuzz
