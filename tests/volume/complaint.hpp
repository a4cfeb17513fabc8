#pragma once
#include <string>

#include "ringsplat/base/error.hpp"

/// The message when `f` meets bad input; empty when all goes well.
template <class F>
std::string complaint_of(F&& f) {
  try {
    f();
  } catch (const ringsplat::InputError& error) {
    return error.what();
  }
  return {};
}

inline bool says(const std::string& complaint, const std::string& fragment) {
  return complaint.find(fragment) != std::string::npos;
}
