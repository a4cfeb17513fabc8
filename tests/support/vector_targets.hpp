#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace ringsplat {

/// The vector instruction set in use ("AVX3", "AVX2", "NEON", "SCALAR" ...).
const char* vector_target();

/// The instruction sets that both this program and the processor have, best first.
std::vector<std::string> vector_targets();
/// Uses only the named instruction set from now on, or the best one again when `name` is empty or unknown. Do
/// not call while another thread draws.
void use_vector_target(const std::string& name);

}  // namespace ringsplat
