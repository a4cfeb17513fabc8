#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

/// Measurements kept from run to run below the user's cache folder, one file each.
namespace ringsplat::app {

/// The path, size and time of the last change; of a folder only the time. Zeros when it cannot be read.
nlohmann::json identity_of(const std::filesystem::path& path);

/// Identifies a build by its version and the program's file, as one version may be built more than once.
nlohmann::json this_program();

/// The file of a measurement.
struct KeptFile {
  std::string kind;                 ///< what is kept, in a word
  std::string key;                  ///< all that it depends on, as JSON
  std::filesystem::path path = {};  ///< empty: nothing is kept
};
/// Its path is in $XDG_CACHE_HOME/ringsplat, else ~/.cache/ringsplat (XDG base directory specification, which
/// says to ignore a relative XDG_CACHE_HOME); empty without a home folder.
KeptFile kept_file(const std::string& kind, const std::string& key);

/// Passes what the file has for its key to `take`, which throws where it is none of its kind. False when
/// there is no such file, or when it cannot be understood, of which it warns.
bool read_kept(const KeptFile& file, const std::function<void(const nlohmann::json&)>& take);

/// Creates the folder if needed, writes beside the file and renames. Only warns on failure: the next run then
/// measures again.
void write_kept(const KeptFile& file, const nlohmann::json& measured);

}  // namespace ringsplat::app
