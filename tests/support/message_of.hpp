#pragma once
#include <string>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

/// The message of the Error, bad input unless told otherwise, that `f` throws; empty when it throws nothing.
/// Any other exception passes through.
template <class Error = InputError, class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

inline bool says(const std::string& message, const std::string& words) {
  return message.find(words) != std::string::npos;
}

}  // namespace ringsplat
