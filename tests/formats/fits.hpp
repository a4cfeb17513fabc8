#pragma once
#include <fmt/format.h>

#include <map>

#include "formats/files.hpp"

namespace files {

/// A header of cards, to the end of a block. `first`: SIMPLE or XTENSION with its value.
inline std::string fits(const std::map<std::string, std::string>& cards,
                        const std::string& first = "SIMPLE  = T") {
  std::string bytes = fmt::format("{:80}", first);
  for (const auto& [key, value] : cards) bytes += fmt::format("{:8}= {:70}", key, value);
  bytes += fmt::format("{:80}", "END");
  return bytes + std::string((2880 - bytes.size() % 2880) % 2880, ' ');
}
/// That of the sample volume; `more` changes it.
inline std::string fits_cube(int bits, const std::map<std::string, std::string>& more = {},
                             const std::string& first = "SIMPLE  = T") {
  std::map<std::string, std::string> cards = more;
  cards.insert({{"BITPIX", std::to_string(bits)},
                {"NAXIS", "3"},
                {"NAXIS1", std::to_string(nx)},
                {"NAXIS2", std::to_string(ny)},
                {"NAXIS3", std::to_string(nz)}});
  return fits(cards, first);
}

}  // namespace files
