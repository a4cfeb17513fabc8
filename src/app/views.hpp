#pragma once
#include <fmt/format.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "options/options.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

/// `frames` views once around the volume: azimuths from start.azimuth on in steps of 360/frames degrees.
std::vector<Camera> orbit(const Camera& start, int frames);

/// Says what a line of a path may be, for messages.
extern const char* const path_line_hint;

/// A line of a path, without its line feed.
struct PathLine {
  static constexpr std::size_t most_bytes = 4096;
  std::string text;        ///< no more than the first most_bytes
  std::size_t number = 0;  ///< from 1
  bool too_long = false;
};
/// Takes a stream's next line; false at its end.
bool next_line(std::istream& in, PathLine& line);

/// Reads a path line by line. A line is a camera: "azimuth elevation [roll [zoom]]" with blanks, commas or
/// semicolons, or a JSON object with these keys, "fov", "distance" or "matrix" (12 numbers). Column names
/// before the first view give another order; lines that are empty or begin with # are skipped. Missing values
/// are taken from `defaults`.
class PathReader {
 public:
  explicit PathReader(const Camera& defaults);
  /// The line's view, if it gives one. Throws InputError that begins with `where` and shows an excerpt.
  std::optional<Camera> read(const PathLine& line, const std::string& where);

 private:
  Camera defaults_;
  std::vector<double Camera::*> columns_;
  bool view_came_ = false;
};

/// A whole path. Throws InputError naming file and line; also when there is no view, or more than
/// most_views.
std::vector<Camera> read_path(const std::filesystem::path& file, const Camera& defaults);
std::vector<Camera> parse_path(std::istream& in, const std::string& where, const Camera& defaults);
constexpr std::size_t most_views = 1'000'000;

/// The run's views that are known beforehand: one, an orbit or a path; none when they come on stdin. Throws
/// InputError for a path that cannot be read.
std::vector<Camera> views_of(const RenderOptions& options);

/// OUT.png -> OUT-0007.png.
std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index);

/// Views that arrive line by line during the run (`--path -`), in the format of a path's file. A thread of
/// its own reads them and pauses while enough of them wait. A line that gives no view is skipped with a
/// warning.
class ViewStream {
 public:
  static constexpr std::size_t room = 64;            ///< views that may wait
  static constexpr std::size_t most_warnings = 100;  ///< warnings of bad lines; more are only counted

  /// Callbacks, called on the stream's thread.
  struct Hooks {
    std::function<void(const Camera&)> check;  ///< throws InputError for a view that cannot be rendered
    std::function<void(const std::string&)> warn;
  };

  /// Reads `in` to its end. What the hooks refer to must outlive what is returned; `in` also a thread that
  /// waits for a line then, as of stdin.
  static std::shared_ptr<ViewStream> of(std::istream& in, std::string name, const Camera& defaults,
                                        Hooks hooks) {
    const std::shared_ptr<ViewStream> stream(new ViewStream(std::move(name), defaults, std::move(hooks)));
    std::thread([stream, &in] { stream->read(in); }).detach();
    return {stream.get(), [stream](ViewStream*) { stream->stop(); }};
  }

  /// The next view that has arrived, if any.
  std::optional<Camera> next() {
    const std::lock_guard lock(mutex_);
    if (views_.empty()) return std::nullopt;
    const Camera view = views_.front();
    views_.pop_front();
    changed_.notify_all();
    return view;
  }

  /// True while more may come; false once the stream has ended and all views are taken.
  bool may_come() {
    const std::lock_guard lock(mutex_);
    return !views_.empty() || !ended_;
  }

  /// Throws InputError when lines were skipped, when no view came or when reading failed. Call it when
  /// may_come() has become false.
  void check_all_was_read() {
    const std::lock_guard lock(mutex_);
    if (failed_)
      throw InputError(fmt::format("{}: stdin cannot be read to its end; views rendered: {}", name_, taken_),
                       "redirect a file or a pipe to it");
    if (skipped_ > 0)
      throw InputError(fmt::format("{}: {} of the lines give no view and were skipped; views rendered: {}",
                                   name_, skipped_.load(), taken_),
                       "the warnings above say what is wrong with them");
    if (taken_ == 0) throw InputError(fmt::format("{}: no view came on stdin", name_), path_line_hint);
  }

 private:
  ViewStream(std::string name, const Camera& defaults, Hooks hooks)
      : name_(std::move(name)), hooks_(std::move(hooks)), reader_(defaults) {}

  void read(std::istream& in) {
    for (PathLine line; !stopping_ && !ended_;)
      if (!next_line(in, line))
        failed_ = in.bad(), ended_ = true;
      else if (const auto view = view_of(line))
        put(*view);
  }

  /// No hook is called any more.
  void stop() {
    const std::lock_guard calling(calls_);
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
  }

  std::optional<Camera> view_of(const PathLine& line) {
    const std::lock_guard calling(calls_);
    if (stopping_) return std::nullopt;
    const std::string where = fmt::format("{}, line {}", name_, line.number);
    try {
      const auto view = reader_.read(line, where);
      if (view) hooks_.check(*view);
      return view;
    } catch (const InputError& e) {
      const std::string what = e.what();
      skip(what.starts_with(where) ? what : where + ": " + what);
      return std::nullopt;
    }
  }

  void skip(const std::string& why) {
    const std::size_t skipped = ++skipped_;
    if (skipped <= most_warnings) hooks_.warn("skipped " + why);
    if (skipped == most_warnings)
      hooks_.warn(fmt::format("{}: further lines that give no view are only counted", name_));
  }

  void put(const Camera& view) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return views_.size() < room || stopping_; });
    views_.push_back(view);
    ++taken_;
  }

  const std::string name_;
  const Hooks hooks_;
  PathReader reader_;  ///< used by the thread only
  std::mutex calls_;   ///< held while hooks are called; taken before the other
  std::mutex mutex_;   ///< guards what follows
  std::condition_variable changed_;
  std::deque<Camera> views_;
  std::size_t taken_ = 0;  ///< views in all
  std::atomic<bool> failed_{false}, ended_{false}, stopping_{false};
  std::atomic<std::size_t> skipped_{0};  ///< lines in all
};

}  // namespace ringsplat::app
