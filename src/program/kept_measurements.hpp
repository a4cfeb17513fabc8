#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

/// Measurements kept from run to run below the user's cache folder, one file each.
namespace ringsplat::app {

/// $XDG_CACHE_HOME/ringsplat, else ~/.cache/ringsplat (XDG base directory specification, which says to ignore
/// a relative XDG_CACHE_HOME); nothing without a home folder.
std::optional<std::filesystem::path> cache_folder();

/// The path, size and time of the last change; of a folder only the time. Zeros when it cannot be read.
nlohmann::json identity_of(const std::filesystem::path& path);

/// Identifies a build by its version and the program's file, as one version may be built more than once.
nlohmann::json this_program();

/// The file of `key` in `folder`. `kind` says what is kept, in a word.
std::filesystem::path kept_file(const std::filesystem::path& folder, const std::string& kind,
                                const std::string& key);

/// Passes what the file has for `key` (JSON) to `take`, which throws where it is none of its kind. False when
/// there is no such file, or when it cannot be understood, of which it warns.
bool read_kept(const std::filesystem::path& file, const std::string& kind, const std::string& key,
               const std::function<void(const nlohmann::json&)>& take);

/// Creates the folder if needed, writes beside the file and renames. Only warns on failure: the next run then
/// measures again.
void write_kept(const std::filesystem::path& file, const std::string& kind, const std::string& key,
                const nlohmann::json& measured);

}  // namespace ringsplat::app
