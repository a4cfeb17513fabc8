#pragma once
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "ringsplat/base/error.hpp"

/// Reads members of untrusted JSON; all throw InputError that names the member.
namespace ringsplat::serve {

inline double number_from(const nlohmann::json& j, const std::string& name, double low, double high) {
  const double value = j.is_number() ? j.get<double>() : NAN;
  if (!(value >= low && value <= high))
    throw InputError(fmt::format("{} must be a number from {:g} to {:g}", name, low, high));
  return value;
}

inline const nlohmann::json& member(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) throw InputError(fmt::format("the message has no {}", name));
  return *found;
}

inline double number(const nlohmann::json& object, const char* name, double low, double high) {
  return number_from(member(object, name), name, low, high);
}

/// A whole number up to 2^32 − 1.
inline std::uint32_t whole(const nlohmann::json& object, const char* name, std::uint32_t low = 0,
                           std::uint32_t high = UINT32_MAX) {
  return static_cast<std::uint32_t>(number(object, name, low, high));
}

/// A list of `least` to `most` entries.
inline const nlohmann::json& list_from(const nlohmann::json& j, const std::string& name, std::size_t least,
                                       std::size_t most) {
  if (!j.is_array() || j.size() < least || j.size() > most)
    throw InputError(least == most ? fmt::format("{} must be a list of {}", name, least)
                                   : fmt::format("{} must be a list of {} to {}", name, least, most));
  return j;
}

}  // namespace ringsplat::serve
