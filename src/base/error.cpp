#include "ringsplat/base/error.hpp"

namespace ringsplat {

Error::Error(ExitCode code, const std::string& problem, const std::string& hint)
    : std::runtime_error(hint.empty() ? problem : problem + "; hint: " + hint), code_(code) {}

}  // namespace ringsplat
