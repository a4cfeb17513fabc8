#pragma once
#include <span>
#include <string>

namespace ringsplat::app {

/// This build's version and wire format, in words.
std::string build_id();

/// Throws InputError that names the first rank whose build differs from rank 0's, and both builds.
void require_same_build(std::span<const std::string> builds_by_rank);

}  // namespace ringsplat::app
