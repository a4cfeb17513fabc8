#pragma once
#include <optional>
#include <span>
#include <string>

#include "ringsplat/base/fact.hpp"
#include "ringsplat/net/collectives.hpp"

namespace ringsplat {

/// Where a process's facts are not those of process 0.
struct Disagreement {
  int process = 0;                                      ///< the lowest that differs
  int others = 0;                                       ///< how many more differ, in whatever field
  std::string field = {}, value = {}, value_on_0 = {};  ///< of the first fact that differs
};

/// Compares all processes' facts with those of process 0; every process gets the same answer. Sends 8 bytes a
/// process, and all facts of two processes only when some differ. A field that one of them lacks counts as
/// "(none)".
std::optional<Disagreement> find_disagreement(Collectives& collectives, const Facts& mine);

/// Throws on all processes the InputError "rank 2 WHAT: FIELD VALUE, rank 0 has VALUE" when one differs from
/// process 0.
void require_same(Collectives& collectives, const Facts& mine, const std::string& what,
                  const std::string& hint);

}  // namespace ringsplat
