#pragma once
#include <functional>
#include <string>

namespace ringsplat::python {

/// What long work calls now and then on the thread that called it; either may throw to end the work. Either
/// may be empty.
struct Hooks {
  std::function<void()> poll;
  std::function<void(const std::string& what, double done, double total)> told;
};

}  // namespace ringsplat::python
