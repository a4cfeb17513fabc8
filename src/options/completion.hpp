#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace ringsplat::app {

/// The shells that completion() knows, as --help shows them.
inline constexpr const char* completion_shells = "bash|zsh|fish";

/// A script for that shell that completes subcommands, options and their values: words of a choice, names of
/// transfer functions and the like, files. Throws InputError for a shell that it does not know.
std::string completion(const CLI::App& program, const std::string& shell);

}  // namespace ringsplat::app
