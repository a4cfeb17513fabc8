#pragma once
#include "app/program_runner.hpp"
#include "support/catch.hpp"

namespace ringsplat::app_test {

/// Requires that a program has done what it was asked for, and says what it has written to stderr if not.
inline Ended succeeded(Ended ended) {
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  return ended;
}

}  // namespace ringsplat::app_test
