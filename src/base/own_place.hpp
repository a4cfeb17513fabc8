#pragma once
#include <filesystem>
#include <vector>

namespace ringsplat {

/// The folder of the program, or of the shared library, that this code is part of; empty where it is unknown.
std::filesystem::path own_folder();

/// The folders where the loader looks for that program's or library's own libraries.
std::vector<std::filesystem::path> own_search_path();

}  // namespace ringsplat
