#include "fuzz/driver.hpp"

#include <algorithm>

#include "support/temporary_folder.hpp"

namespace ringsplat::fuzz {

const std::vector<Driver>& drivers() {
  static const std::vector<Driver> all = [] {
    std::vector<Driver> list;
    for (const auto& some : {volume_drivers(), text_drivers(), message_drivers(), rank_drivers()})
      list.insert(list.end(), some.begin(), some.end());
    return list;
  }();
  return all;
}

const std::filesystem::path& scratch() {
  static const support::TemporaryFolder folder;
  return folder.path();
}

void append_part(Input& input, std::span<const std::byte> part) {
  const auto length = static_cast<std::uint32_t>(part.size());
  input.append(reinterpret_cast<const char*>(&length), sizeof length);
  input.append(text_of(part));
}

bool take_part(std::span<const std::byte>& input, std::span<const std::byte>& part) {
  std::uint32_t length = 0;
  if (input.size() < sizeof length) return false;
  std::memcpy(&length, input.data(), sizeof length);
  input = input.subspan(sizeof length);
  part = input.first(std::min<std::size_t>(length, input.size()));
  input = input.subspan(part.size());
  return true;
}

Input input_of_parts(std::initializer_list<std::string_view> parts) {
  Input input;
  for (const std::string_view part : parts) append_part(input, bytes_of_input(part));
  return input;
}

void take_parts(std::span<const std::byte> input, std::initializer_list<std::string*> parts) {
  std::span<const std::byte> part;
  for (std::string* const text : parts)
    if (take_part(input, part)) *text = text_of(part);
}

}  // namespace ringsplat::fuzz
