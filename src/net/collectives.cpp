#include "net/collectives.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "net/agree.hpp"
#include "net/blocks.hpp"

namespace ringsplat {

void throw_first(const std::vector<std::string>& errors) {
  const auto failed = [](const std::string& error) { return !error.empty(); };
  const auto first = std::find_if(errors.begin(), errors.end(), failed);
  if (first == errors.end()) return;
  const auto others = std::count_if(first + 1, errors.end(), failed);
  const bool same_everywhere = std::count(errors.begin(), errors.end(), *first) == std::ssize(errors);
  if (same_everywhere || (first == errors.begin() && others == 0)) throw InputError(*first);
  throw InputError(*first + fmt::format(" (on rank {}{})", first - errors.begin(),
                                        others > 0 ? fmt::format(" and {} more", others) : ""));
}

void agree(Collectives& collectives, const std::string& my_error) {
  std::vector<std::string> errors;
  for (const Block& block : collectives.all_gather(block_of_text(my_error))) errors.push_back(text_of(block));
  throw_first(errors);
}

}  // namespace ringsplat
