#pragma once
#include <string>

namespace ringsplat::app {

/// What --version prints: the version, and which libraries this build has and which were left out.
std::string version_text();

}  // namespace ringsplat::app
