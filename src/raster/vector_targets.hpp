#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace ringsplat {

/// The vector instruction set in use ("AVX3", "AVX2", "SSE4", "NEON", "SCALAR" ...), for the log.
const char* vector_target();

/// The instruction sets this program has and this processor supports, best first; for tests that compare
/// them.
std::vector<std::string> vector_targets();
/// Uses only the named one from now on; all again when empty. Not for use while another thread draws.
void use_vector_target(const std::string& name);

}  // namespace ringsplat
