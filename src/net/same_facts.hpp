#pragma once
#include <optional>
#include <span>
#include <string>

#include "net/collectives.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat {

/// How a process's facts differ from those of process 0.
struct Disagreement {
  int process = 0;  ///< the lowest process that differs
  int others = 0;   ///< number of further processes that differ, in any field
  std::string field = {}, value = {}, value_on_0 = {};  ///< of the first fact that differs
};

/// Compares all processes' facts with those of process 0; every process gets the same answer. Sends a hash of
/// 8 bytes a process, and two processes' whole facts only when some differ. A missing field counts as
/// "(none)".
std::optional<Disagreement> find_disagreement(Collectives& collectives, const Facts& mine);

/// When a process differs from process 0, throws on all the InputError "rank 2 WHAT: FIELD VALUE, rank 0 has
/// VALUE".
void require_same(Collectives& collectives, const Facts& mine, const std::string& what,
                  const std::string& hint);

}  // namespace ringsplat
