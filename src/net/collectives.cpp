#include "net/collectives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

void agree(Collectives& collectives, const std::string& my_error) {
  const auto text_bytes = std::as_bytes(std::span(my_error));
  const Block mine(text_bytes.begin(), text_bytes.end());
  const auto all = collectives.all_gather(mine);
  const auto failed = [](const Block& b) { return !b.empty(); };
  const auto first = std::find_if(all.begin(), all.end(), failed);
  if (first == all.end()) return;
  std::string text(reinterpret_cast<const char*>(first->data()), first->size());
  const auto others = std::count_if(first + 1, all.end(), failed);
  if (all.size() > 1 && (others > 0 || first != all.begin()))
    text += fmt::format(" (on rank {}{})", first - all.begin(),
                        others > 0 ? fmt::format(" and {} more", others) : "");
  throw InputError(text);
}

}  // namespace ringsplat
