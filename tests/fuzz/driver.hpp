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
/// crash, more time or more memory than the watch allows is a finding. `run` also uses the result, and throws
/// std::logic_error when it breaks the decoder's promises.
struct Driver {
  const char* name;  ///< also the name of its folders below seeds/ and crashes/
  void (*run)(std::span<const std::byte> input);
  std::vector<Input> (*seeds)();
  std::vector<std::string_view> words;  ///< words that its texts are made of
  int short_inputs;                     ///< inputs of the run as a test, about half a second
};

const std::vector<Driver>& drivers();
std::vector<Driver> volume_drivers();
std::vector<Driver> text_drivers();
std::vector<Driver> message_drivers();
std::vector<Driver> rank_drivers();

/// A folder for files that drivers read, removed at the end of the process that first called it.
const std::filesystem::path& scratch();

inline std::span<const std::byte> bytes_of_input(std::string_view input) {
  return std::as_bytes(std::span(input));
}
inline std::string_view text_of(std::span<const std::byte> input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}
/// A copy in an allocation of its own, so that reading beyond its end is detected; aligned like messages.
inline Bytes copy_of(std::span<const std::byte> input) { return {input.begin(), input.end()}; }

/// Takes the first byte off an input, for a driver's choices; 0 when there is none.
inline unsigned take_choice(std::span<const std::byte>& input) {
  if (input.empty()) return 0;
  const auto choice = std::to_integer<unsigned>(input.front());
  input = input.subspan(1);
  return choice;
}

/// Appends a part to an input of several, as drivers of whole exchanges take them: four bytes of length, then
/// the part.
void append_part(Input& input, std::span<const std::byte> part);
/// Takes the next part, or what is left of one that is cut short. False at the end.
bool take_part(std::span<const std::byte>& input, std::span<const std::byte>& part);
/// An input of texts, and those texts; empty ones where it ends before.
Input input_of_parts(std::initializer_list<std::string_view> parts);
void take_parts(std::span<const std::byte> input, std::initializer_list<std::string*> parts);

// Seeds in files of their own.
std::vector<Input> hdf5_seeds();  ///< every layout, the old and the new format, and each convention
std::vector<Input> tiff_seeds();  ///< byte orders, strips, tiles, packed with PackBits or deflate; a PNG file

}  // namespace ringsplat::fuzz
