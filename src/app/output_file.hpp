#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace ringsplat::app {

/// Throws InputError naming `option` unless a file can be made where `path` says: its folder exists and can
/// be written, and `path` is no folder itself. Leaves nothing behind.
void check_can_write(const std::filesystem::path& path, const std::string& option);

/// Calls `write(temporary)` with a path beside `path` that has the same ending, then renames it to `path`.
/// When `write` throws, the temporary file is removed and the exception goes on. Throws RunError when the
/// renaming fails.
void write_beside(const std::filesystem::path& path,
                  const std::function<void(const std::filesystem::path&)>& write);

/// A whole text file, by write_beside. Throws RunError (disk full, ...).
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace ringsplat::app
