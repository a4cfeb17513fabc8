#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "base/printable.hpp"

namespace ringsplat::app {

/// Turns every minus zero into zero.
template <class Json>
void make_plain(Json& j) {
  if (j.is_structured())
    for (auto& part : j) make_plain(part);
  else if (j.is_number_float())
    j = plain(j.template get<double>());
}

/// A JSON text for people and programs: no minus zero, and bytes that are not UTF-8 (in file names) are
/// replaced. `indent` -1: on one line.
template <class Json>
std::string plain_json_text(Json j, int indent = -1) {
  make_plain(j);
  return j.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ringsplat::app
