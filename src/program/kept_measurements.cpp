#include "program/kept_measurements.hpp"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/log.hpp"
#include "base/output_file.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Empty: there is none.
fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && fs::path(cache).is_absolute()) return fs::path(cache) / "ringsplat";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return fs::path(home) / ".cache" / "ringsplat";
  return {};
}

}  // namespace

json identity_of(const fs::path& path) {
  std::error_code ignored;
  const auto changed = fs::last_write_time(path, ignored).time_since_epoch().count();
  const auto bytes = fs::is_directory(path, ignored) ? 0 : fs::file_size(path, ignored);
  return {{"path", fs::weakly_canonical(path, ignored).string()}, {"bytes", bytes}, {"changed", changed}};
}

json this_program() {
  json j = identity_of("/proc/self/exe");
  j.erase("path");
  j["version"] = RINGSPLAT_VERSION;
  return j;
}

KeptFile kept_file(const std::string& kind, const std::string& key) {
  KeptFile file{kind, key};
  if (const fs::path folder = cache_folder(); !folder.empty())
    file.path = folder / fmt::format("{}-{:016x}.json", kind, std::hash<std::string>{}(key));
  return file;
}

bool read_kept(const KeptFile& file, const std::function<void(const json&)>& take) {
  std::error_code ignored;
  if (!fs::exists(file.path, ignored)) return false;
  std::string problem;
  try {
    std::ifstream in(file.path, std::ios::binary);
    const json stored = json::parse(in);
    if (stored.at("key") == json::parse(file.key)) {
      take(stored.at("measured"));
      return true;
    }
    problem = "it was made for something else";
  } catch (const std::exception& e) {
    problem = e.what();
  }
  log_warning("the {} {} cannot be used and is made again: {}", file.kind, file.path.string(), problem);
  return false;
}

void write_kept(const KeptFile& file, const json& measured) {
  if (file.path.empty()) return;
  try {
    fs::create_directories(file.path.parent_path());
    write_text(file.path, json{{"key", json::parse(file.key)}, {"measured", measured}}.dump(1) + "\n");
  } catch (const std::exception& e) {
    log_warning("the {} cannot be kept for the next run: {}; hint: XDG_CACHE_HOME says where", file.kind,
                e.what());
  }
}

}  // namespace ringsplat::app
