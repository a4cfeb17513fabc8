#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace ringsplat::app {

/// Which truth a picture is measured against (docs/accuracy.md).
enum class TruthKind { method, field, analytic };
std::string to_string(TruthKind kind);
/// Throws InputError that lists the names; `option` is the option that was given.
TruthKind truth_from(const std::string& name, const std::string& option);

/// What `render --error` measures.
struct ErrorOptions {
  std::optional<TruthKind> truth;  ///< nothing: measure nothing
  std::size_t pixels = 4096;       ///< pixels at which the truth is evaluated
  std::uint64_t seed = 1;
};

}  // namespace ringsplat::app
