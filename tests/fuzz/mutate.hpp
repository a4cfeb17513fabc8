#pragma once
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {

inline constexpr std::size_t longest_input = std::size_t{64} << 10;  ///< bytes

/// Makes inputs from seeds: changes bits and bytes, replaces numbers by ones that programs often get wrong,
/// cuts, doubles or swaps in parts, and inserts words of the format. The same seed number gives the same
/// inputs on every machine.
class Mutator {
 public:
  /// `words` must outlive it.
  Mutator(std::uint64_t seed, std::span<const std::string_view> words) : random_(seed), words_(words) {}
  /// `seeds` is not empty.
  Input next(std::span<const Input> seeds);

 private:
  // Not std::uniform_int_distribution: its results differ between standard libraries.
  std::size_t below(std::size_t bound) { return bound == 0 ? 0 : std::size_t(random_() % bound); }
  void change(Input& input, std::span<const Input> seeds);
  void flip_bit(Input& input);
  void set_byte(Input& input);
  void set_integer(Input& input);
  void add_to_integer(Input& input);
  void cut(Input& input);
  void truncate(Input& input);
  void repeat(Input& input);
  void splice(Input& input, std::span<const Input> seeds);
  void put_word(Input& input);
  void replace_number(Input& input);
  void move_line(Input& input);

  std::mt19937_64 random_;
  std::span<const std::string_view> words_;
};

}  // namespace ringsplat::fuzz
