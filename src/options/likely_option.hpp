#pragma once
#include <string>
#include <vector>

namespace ringsplat::app {

/// "did you mean --colours?" for an option that is not among the `known` ones: what other programs' word for
/// it is called here, or else the most similar one. Empty when nothing is like it. Dashes and underscores are
/// alike.
std::string likely_option(const std::string& unknown, const std::vector<std::string>& known);

}  // namespace ringsplat::app
