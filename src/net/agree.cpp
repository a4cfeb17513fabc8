#include "net/agree.hpp"

#include <algorithm>

#include "base/fingerprint.hpp"
#include "net/blocks.hpp"

namespace ringsplat {
namespace {

/// The first field that differs, among process 0's fields first, then among the other's.
std::string difference(const Facts& on_0, const Facts& there) {
  const auto value_in = [](const Facts& facts, const std::string& field) {
    const auto at = std::find_if(facts.begin(), facts.end(), [&](const Fact& f) { return f.field == field; });
    return at == facts.end() ? "(none)" : at->value;
  };
  for (const Facts* facts : {&on_0, &there})
    for (const auto& [field, value] : *facts)
      if (value_in(there, field) != value_in(on_0, field))
        return fmt::format("{} {}, rank 0 has {}", field, value_in(there, field), value_in(on_0, field));
  return {};
}

}  // namespace

void require_same(Collectives& collectives, const Facts& mine, const std::string& what,
                  const std::string& hint) {
  const Block facts = to_bytes(mine);
  const auto hashes = collectives.all_gather(to_bytes(fingerprint(facts)));
  const auto differs = [&](const Block& hash) { return hash != hashes.front(); };
  const auto first = std::find_if(hashes.begin(), hashes.end(), differs);
  if (first == hashes.end()) return;
  const int process = int(first - hashes.begin());
  const auto more = std::count_if(first + 1, hashes.end(), differs);
  const auto said_by = [&](int root) {
    return value_of<Facts>(collectives.broadcast(collectives.process() == root ? facts : Block{}, root),
                           "its facts");
  };
  const Facts on_0 = said_by(0);
  const std::string others = more == 0   ? ""
                             : more == 1 ? " (1 more rank differs)"
                                         : fmt::format(" ({} more ranks differ)", more);
  throw InputError(fmt::format("rank {} {}: {}{}", process, what, difference(on_0, said_by(process)), others),
                   hint);
}

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
  for (const Block& block : collectives.all_gather(to_bytes(my_error)))
    errors.push_back(value_of<std::string>(block, "an error"));
  throw_first(errors);
}

}  // namespace ringsplat
