#pragma once
#include <string>

#include "ringsplat/base/error.hpp"

namespace ringsplat::test {

/// What a call complains of; "none" when it does not.
template <class F>
std::string run_error_of(F&& call) {
  try {
    call();
  } catch (const RunError& e) {
    return e.what();
  }
  return "none";
}

}  // namespace ringsplat::test
