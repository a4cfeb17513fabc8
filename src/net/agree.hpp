#pragma once
#include <string>
#include <vector>

#include "net/collectives.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/base/fact.hpp"

namespace ringsplat {

/// The InputError that `work` throws, as text; empty when it throws none.
template <class Work>
std::string input_error_of(const Work& work) {
  try {
    work();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

/// Runs `work` on every process; when one throws InputError, all throw it as agree() does.
template <class Work>
void agree_after(Collectives& collectives, const Work& work) {
  agree(collectives, input_error_of(work));
}

/// Throws InputError with the first of all processes' errors, unless all are empty. Says whose it is
/// unless all have the same, or process 0 alone has one.
void throw_first(const std::vector<std::string>& errors);

/// Compares all processes' facts with those of process 0. When a process differs, throws on all the
/// InputError "rank 2 WHAT: FIELD VALUE, rank 0 has VALUE"; a missing field counts as "(none)". Sends a hash
/// of 8 bytes a process, and two processes' whole facts only when some differ.
void require_same(Collectives& collectives, const Facts& mine, const std::string& what,
                  const std::string& hint);

}  // namespace ringsplat
