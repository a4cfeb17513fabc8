#include "layering/layering.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace layering {
namespace {

namespace fs = std::filesystem;

struct SourceFile {
  fs::path path;
  std::string room;
  bool is_public;
};

struct Include {
  int line;
  bool quoted;
  std::string name;
};

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<SourceFile> source_files(const fs::path& top, bool is_public) {
  std::vector<SourceFile> files;
  if (!fs::exists(top)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(top)) {
    const auto extension = entry.path().extension();
    if (extension != ".hpp" && extension != ".cpp" && extension != ".h") continue;
    const auto relative = entry.path().lexically_relative(top);
    const bool in_a_room = std::distance(relative.begin(), relative.end()) > 1;
    files.push_back({entry.path(), in_a_room ? relative.begin()->string() : "", is_public});
  }
  return files;
}

std::vector<Include> includes_of(const fs::path& file) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::vector<Include> includes;
  std::istringstream text(text_of(file));
  std::string line;
  for (int number = 1; std::getline(text, line); ++number)
    if (std::smatch match; std::regex_search(line, match, pattern))
      includes.push_back({number, match[1] == "\"", match[2]});
  return includes;
}

bool is_mpi(const std::string& include) { return include == "mpi.h"; }
bool is_openimageio(const std::string& include) { return include.rfind("OpenImageIO/", 0) == 0; }

/// "ringsplat/ROOM/..." names ROOM's public header.
std::optional<std::string> public_room(const std::string& include) {
  static const std::regex pattern(R"(ringsplat/([^/]+)/.+)");
  std::smatch match;
  return std::regex_match(include, match, pattern) ? std::optional<std::string>(match[1]) : std::nullopt;
}

class Checker {
 public:
  Checker(const fs::path& root, const Rules& rules) : root_(root), rules_(rules) {
    files_ = source_files(root / "include" / "ringsplat", true);
    const auto sources = source_files(root / "src", false);
    files_.insert(files_.end(), sources.begin(), sources.end());
    if (files_.empty()) throw std::runtime_error("no source file below " + root.string());
    for (const auto& file : files_)
      for (const auto& include : includes_of(file.path))
        if (file.is_public && is_mpi(include.name))
          headers_with_mpi_.insert(file.path.lexically_relative(root / "include").generic_string());
  }

  std::vector<std::string> run() {
    for (const auto& file : files_) {
      if (file.is_public && file.room.empty()) continue;  // for programs, of all rooms
      if (rules_.count(file.room) == 0) {
        report(file.path, 1, "is in no room; the rooms are listed in tests/layering/layering.cpp");
        continue;
      }
      for (const auto& include : includes_of(file.path)) check(file, include);
    }
    check_linking();
    std::sort(found_.begin(), found_.end());
    return found_;
  }

 private:
  void report(const fs::path& file, int line, const std::string& problem) {
    found_.push_back(file.lexically_relative(root_).generic_string() + ":" + std::to_string(line) + ": " +
                     problem);
  }

  bool may_use(const std::string& room, const std::string& other) const {
    return room == other || rules_.at(room).count(other) > 0;
  }

  void check(const SourceFile& file, const Include& include) {
    if (is_mpi(include.name) && file.room != "mpi")
      report(file.path, include.line, "includes mpi.h, which only mpi may");
    if (is_openimageio(include.name) && file.room != "images")
      report(file.path, include.line, "includes " + include.name + ", which only images may");
    if (headers_with_mpi_.count(include.name) > 0 && file.room != "mpi")
      report(file.path, include.line, "includes mpi.h by way of " + include.name);
    if (const auto room = public_room(include.name)) {
      if (rules_.count(*room) == 0)
        report(file.path, include.line, "includes " + include.name + ", which is in no room");
      else if (!may_use(file.room, *room))
        report(file.path, include.line, file.room + " may not use " + *room + " (" + include.name + ")");
      return;
    }
    // What CMake writes; every room may know what the build has.
    if (!include.quoted || include.name == "ringsplat/config.hpp") return;
    const std::string room = include.name.substr(0, include.name.find('/'));
    if (file.is_public)
      report(file.path, include.line, "a public header includes the private " + include.name);
    else if (rules_.count(room) == 0)
      report(file.path, include.line, "\"" + include.name + "\" is no header of a room");
    // Of frame the truth knows what describes one only.
    else if (!may_use(file.room, room) || (file.room == "truth" && room == "frame"))
      report(file.path, include.line, file.room + " may not use " + room + " (" + include.name + ")");
  }

  /// A room that is linked with another can use it without an include line, so the build's lists are checked
  /// too.
  void check_linking() {
    static const std::regex call(R"(ringsplat_room\(\s*([a-z_]+)\s+USES((\s+[a-z_]+)+))");
    const auto file = root_ / "src" / "CMakeLists.txt";
    const std::string text = text_of(file);
    for (std::sregex_iterator match(text.begin(), text.end(), call), end; match != end; ++match) {
      const std::string room = (*match)[1];
      const auto line = 1 + int(std::count(text.begin(), text.begin() + match->position(), '\n'));
      std::istringstream used((*match)[2]);
      for (std::string other; used >> other;)
        if (rules_.count(room) == 0 || !may_use(room, other))
          report(file, line, room + " may not be linked with " + other);
    }
  }

  fs::path root_;
  const Rules& rules_;
  std::vector<SourceFile> files_;
  std::set<std::string> headers_with_mpi_;  ///< as they are written in an include line
  std::vector<std::string> found_;
};

}  // namespace

const Rules& house_rules() {
  static const Rules rules{
      {"base", {}},
      {"images", {"base"}},
      {"volume", {"base"}},
      {"formats", {"base", "volume"}},
      {"decode", {"base", "images", "volume", "formats"}},
      {"classify", {"base", "volume"}},
      {"view", {"base"}},
      {"screen", {"base"}},
      {"raster", {"base", "view", "screen"}},
      {"splat", {"base", "view", "screen", "raster"}},
      {"net", {"base"}},
      {"record", {"base", "net"}},
      {"protocol", {"base", "net", "record"}},
      {"frame", {"base", "volume", "classify", "view", "screen", "splat"}},
      {"engine_parts", {"base", "volume", "view", "screen", "raster", "net", "protocol", "frame"}},
      {"splat_engine",
       {"base", "volume", "classify", "view", "screen", "raster", "splat", "net", "record", "protocol",
        "frame", "engine_parts"}},
      {"sheet_engine",
       {"base", "volume", "classify", "view", "screen", "raster", "net", "protocol", "frame",
        "engine_parts"}},
      {"scene", {"base", "volume", "classify", "net"}},
      {"session",
       {"base", "volume", "classify", "view", "splat", "net", "record", "protocol", "frame", "splat_engine",
        "sheet_engine", "scene"}},
      {"simulate",
       {"base", "volume", "classify", "view", "screen", "raster", "splat", "net", "protocol", "frame",
        "engine_parts", "splat_engine", "sheet_engine", "session", "mpi"}},
      {"live", {"base", "volume", "classify", "net", "frame", "session", "serve"}},
      {"serve", {"base", "images", "volume", "classify", "view", "frame", "session", "record"}},
      {"truth", {"base", "volume", "classify", "view", "screen", "frame"}},
      {"mpi", {"base", "net"}},
      {"alone", {"base", "net", "mpi"}},
      {"options", {"base", "images", "volume", "formats", "classify", "net", "frame", "session", "simulate"}},
      {"program", {"base", "volume", "net", "session", "simulate", "mpi", "options"}},
      {"forecast",
       {"base", "volume", "net", "protocol", "frame", "engine_parts", "sheet_engine", "scene", "session",
        "simulate", "options", "program"}},
      {"study", {"base", "volume", "frame", "session", "truth", "options", "program"}},
      {"command_line", {"base", "volume", "classify", "session", "serve", "options"}},
      {"app", {"base",   "images",  "volume",   "formats", "classify", "view",        "net",
               "record", "frame",   "scene",    "session", "simulate", "serve",       "truth",
               "mpi",    "options", "forecast", "program", "study",    "command_line"}},
      {"python",
       {"base", "images", "volume", "formats", "classify", "net", "mpi", "session", "options", "app",
        "words"}},
      {"c", {"base", "images", "mpi", "net", "session", "words"}},
      {"words",
       {"base", "images", "volume", "formats", "classify", "view", "net", "record", "frame", "scene",
        "session", "live", "truth", "mpi", "options", "program", "study", "app"}},
  };
  return rules;
}

std::vector<std::string> violations(const fs::path& root, const Rules& rules) {
  return Checker(root, rules).run();
}

}  // namespace layering
