#include "fuzz/mutate.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <limits>

namespace ringsplat::fuzz {
namespace {

constexpr auto int_max = std::numeric_limits<std::int32_t>::max();
constexpr auto long_max = std::numeric_limits<std::int64_t>::max();

/// Values at which sizes, signs and byte counts overflow.
constexpr std::int64_t integers[] = {0,     1,     2,     3,       7,         8,         16,       64,
                                     100,   127,   128,   255,     256,       1024,      4096,     32767,
                                     32768, 65535, 65536, int_max, 1LL << 31, 1LL << 32, long_max, -1};

// As many to a line as fit.
// clang-format off
constexpr std::string_view numbers[] = {
    "0", "1", "-1", "2", "3", "4", "-3", "10", "255", "65536", "1000000", "2147483647", "-2147483648",
    "4294967295", "4294967296", "1e9", "9223372036854775807", "99999999999999999999", "0.5", "-0", "1e-300",
    "1e300", "1e999", "nan", "inf", "-inf", "0x10", "1e", "", "1 2"};
// clang-format on

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

Input Mutator::next(std::span<const Input> seeds) {
  Input input = seeds[below(seeds.size())];
  // Mostly few changes: the first one refused hides all others.
  const std::size_t changes = 1 + below(std::size_t{1} << below(4));
  for (std::size_t k = 0; k < changes; ++k) change(input, seeds);
  if (input.size() > longest_input) input.resize(longest_input);
  return input;
}

void Mutator::change(Input& input, std::span<const Input> seeds) {
  if (input.empty()) return splice(input, seeds);
  switch (below(14)) {
    case 0:
      return flip_bit(input);
    case 1:
      return set_byte(input);
    case 2:
    case 3:
      return set_integer(input);
    case 4:
      return add_to_integer(input);
    case 5:
      return cut(input);
    case 6:
      return truncate(input);
    case 7:
      return repeat(input);
    case 8:
      return splice(input, seeds);
    case 9:
    case 10:
      return put_word(input);
    case 11:
    case 12:
      return replace_number(input);
    default:
      return move_line(input);
  }
}

void Mutator::flip_bit(Input& input) {
  const std::size_t bit = below(8 * input.size());
  input[bit / 8] = char(input[bit / 8] ^ (1 << bit % 8));
}

void Mutator::set_byte(Input& input) { input[below(input.size())] = char(below(256)); }

void Mutator::set_integer(Input& input) {
  const std::size_t bytes = std::min(std::size_t{1} << below(4), input.size());
  const std::int64_t value = integers[below(std::size(integers))];
  std::array<char, sizeof value> raw{};
  std::memcpy(raw.data(), &value, sizeof value);
  if (below(4) == 0) std::reverse(raw.begin(), raw.begin() + std::ptrdiff_t(bytes));
  // Fields mostly lie at multiples of their size.
  std::size_t at = below(input.size() - bytes + 1);
  if (below(2) == 0) at -= at % bytes;
  std::copy_n(raw.begin(), bytes, input.begin() + std::ptrdiff_t(at));
}

void Mutator::add_to_integer(Input& input) {
  const std::size_t at = below(input.size());
  input[at] = char(input[at] + (below(2) == 0 ? 1 : -1) * int(1 + below(16)));
}

void Mutator::cut(Input& input) {
  const std::size_t at = below(input.size());
  input.erase(at, 1 + below(std::min<std::size_t>(input.size() - at, below(4) == 0 ? 1024 : 16)));
}

void Mutator::truncate(Input& input) { input.resize(below(input.size())); }

void Mutator::repeat(Input& input) {
  const std::size_t at = below(input.size());
  const Input part = input.substr(at, 1 + below(64));
  const std::size_t times = below(16) == 0 ? 1 + below(1000) : 1;
  for (std::size_t k = 0; k < times && input.size() < longest_input; ++k) input.insert(at, part);
}

void Mutator::splice(Input& input, std::span<const Input> seeds) {
  const Input& other = seeds[below(seeds.size())];
  if (other.empty()) return;
  const std::size_t from = below(other.size()), at = below(input.size() + 1);
  if (below(2) == 0)
    input = input.substr(0, at) + other.substr(from);
  else
    input.insert(at, other.substr(from, 1 + below(128)));
}

void Mutator::put_word(Input& input) {
  if (words_.empty()) return set_integer(input);
  const std::string_view word = words_[below(words_.size())];
  const std::size_t at = below(input.size() + 1);
  // Replaces a word, replaces as many bytes, or is inserted.
  const auto apart = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; };
  switch (below(3)) {
    case 0: {
      const auto begin = std::find_if_not(input.begin() + std::ptrdiff_t(at), input.end(), apart);
      input.replace(begin, std::find_if(begin, input.end(), apart), word);
      return;
    }
    case 1:
      input.replace(at, word.size(), word);
      return;
    default:
      input.insert(at, word);
  }
}

void Mutator::replace_number(Input& input) {
  const auto begin = std::find_if(input.begin() + std::ptrdiff_t(below(input.size())), input.end(), is_digit);
  if (begin == input.end()) return set_integer(input);
  input.replace(begin, std::find_if_not(begin, input.end(), is_digit), numbers[below(std::size(numbers))]);
}

void Mutator::move_line(Input& input) {
  const std::size_t at = below(input.size());
  const std::size_t begin = input.rfind('\n', at) == Input::npos ? 0 : input.rfind('\n', at) + 1;
  if (begin >= input.size()) return;
  const std::size_t end = std::min(input.find('\n', begin), input.size() - 1) + 1;
  const Input line = input.substr(begin, end - begin);
  if (below(3) != 0) input.erase(begin, line.size());
  const std::size_t to = input.find('\n', below(input.size() + 1));
  if (below(3) != 0) input.insert(to == Input::npos ? 0 : to + 1, line);
}

}  // namespace ringsplat::fuzz
