#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

/// `frames` views once around the volume: azimuths from start.azimuth on in steps of 360/frames degrees.
std::vector<Camera> orbit(const Camera& start, int frames);

/// Says what a line of a path may be, for messages.
extern const char* const path_line_hint;

/// Cuts text that comes in pieces into lines. Keeps only the beginning of a line that is too long.
class LineSplitter {
 public:
  static constexpr std::size_t most_bytes = 4096;  ///< longest line, without its line feed

  struct Line {
    std::string text;    ///< the first most_bytes if the line is too long
    std::size_t number;  ///< from 1
    bool too_long;
  };
  using Take = std::function<void(const Line&)>;

  /// Calls `take` for each line that ends in this piece, and for a line as soon as it becomes too long.
  void add(std::string_view piece, const Take& take);
  /// Calls `take` for a last line without a line feed.
  void end(const Take& take);

 private:
  void hand_over(const Take& take, bool too_long);

  std::string text_;
  std::size_t number_ = 1;
  bool skipping_ = false;  ///< the rest of a line that was too long
};

/// Reads a path line by line. A line is a camera: "azimuth elevation [roll [zoom]]" with blanks, commas or
/// semicolons, or a JSON object with these keys, "fov", "distance" or "matrix" (12 numbers). Column names
/// before the first view give another order; lines that are empty or begin with # are skipped. Missing values
/// are taken from `defaults`.
class PathReader {
 public:
  explicit PathReader(const Camera& defaults);
  /// The line's view, if it gives one. Throws InputError that begins with `where` and shows an excerpt.
  std::optional<Camera> read(std::string line, const std::string& where);

 private:
  Camera defaults_;
  std::vector<double Camera::*> columns_;
  bool view_came_ = false;
};

/// Throws InputError for a line of more than LineSplitter::most_bytes.
[[noreturn]] void refuse_long_line(const LineSplitter::Line& line, const std::string& where);

/// A whole path. Throws InputError naming file and line; also when there is no view, or more than
/// most_views.
std::vector<Camera> read_path(const std::filesystem::path& file, const Camera& defaults);
std::vector<Camera> parse_path(std::istream& in, const std::string& where, const Camera& defaults);
constexpr std::size_t most_views = 1'000'000;

/// OUT.png -> OUT-0007.png.
std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index);

}  // namespace ringsplat::app
