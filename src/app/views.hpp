#pragma once
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <deque>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
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

/// Views that arrive line by line during the run (`--path -`), in the format of a path's file. A thread of
/// its own reads them and pauses while enough of them wait. A line that gives no view is skipped with a
/// warning.
class ViewStream {
 public:
  static constexpr std::size_t room = 64;              ///< views that may wait
  static constexpr std::size_t most_warnings = 100;    ///< warnings of bad lines; more are only counted
  static constexpr std::size_t most_named_lines = 10;  ///< of those skipped, in the error at the end

  /// Callbacks, called on the stream's thread.
  struct Hooks {
    std::function<void(const Camera&)> check;  ///< throws InputError for a view that cannot be rendered
    std::function<void(const std::string&)> warn;
  };

  /// Reads a file descriptor to its end. The descriptor and what the hooks refer to must outlive the stream.
  ViewStream(int descriptor, std::string name, const Camera& defaults, Hooks hooks)
      : name_(std::move(name)), hooks_(std::move(hooks)), reader_(defaults) {
    if (pipe2(stop_, O_CLOEXEC) != 0)
      throw RunError("no pipe can be made to read views", "too many files are open: see ulimit -n");
    thread_ = std::thread([this, descriptor] { read(descriptor); });
  }

  ~ViewStream() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    close(stop_[1]);
    thread_.join();
    close(stop_[0]);
  }

  ViewStream(const ViewStream&) = delete;
  ViewStream& operator=(const ViewStream&) = delete;

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
    const std::string rendered = fmt::format("the {} view{} that came {} rendered", taken_,
                                             taken_ == 1 ? "" : "s", taken_ == 1 ? "is" : "are");
    if (!failure_.empty())
      throw InputError(fmt::format("{}: stdin cannot be read: {}; {}", name_, failure_, rendered),
                       "redirect a file or a pipe to it");
    if (skipped_ > 0) {
      std::vector<std::string> numbers;
      for (const std::size_t line : skipped_lines_) numbers.push_back(std::to_string(line));
      throw InputError(fmt::format("{}: {} line{} no view and {} skipped ({}{}); {}", name_, skipped_,
                                   skipped_ == 1 ? " gives" : "s give", skipped_ == 1 ? "was" : "were",
                                   joined(numbers, ", "), skipped_ > numbers.size() ? ", ..." : "", rendered),
                       "the warnings above say what is wrong with them");
    }
    if (taken_ == 0) throw InputError(fmt::format("{}: no view came on stdin", name_), path_line_hint);
  }

 private:
  void read(int descriptor) {
    LineSplitter lines;
    const auto take = [this](const LineSplitter::Line& line) { take_line(line); };
    std::vector<char> piece(std::size_t{1} << 16);
    std::string failure;
    while (true) {
      std::array<pollfd, 2> wait{{{descriptor, POLLIN, 0}, {stop_[0], POLLIN, 0}}};
      if (poll(wait.data(), wait.size(), -1) < 0) continue;
      if (wait[1].revents != 0) return;
      const auto bytes = ::read(descriptor, piece.data(), piece.size());
      if (bytes > 0) {
        lines.add({piece.data(), static_cast<std::size_t>(bytes)}, take);
        continue;
      }
      if (bytes == 0) break;
      if (errno == EINTR || errno == EAGAIN) continue;
      failure = std::strerror(errno);
      break;
    }
    lines.end(take);
    const std::lock_guard lock(mutex_);
    failure_ = failure;
    ended_ = true;
  }

  void take_line(const LineSplitter::Line& line) {
    const std::string where = fmt::format("{}, line {}", name_, line.number);
    std::optional<Camera> view;
    try {
      if (line.too_long) refuse_long_line(line, where);
      view = reader_.read(line.text, where);
    } catch (const InputError& e) {
      return skip(line.number, e.what());
    }
    try {
      if (view) hooks_.check(*view);
    } catch (const InputError& e) {
      return skip(line.number, fmt::format("{}: {}", where, e.what()));
    }
    if (view) put(*view);
  }

  void skip(std::size_t line, const std::string& why) {
    std::size_t skipped = 0;
    {
      const std::lock_guard lock(mutex_);
      skipped = ++skipped_;
      if (skipped <= most_named_lines) skipped_lines_.push_back(line);
    }
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
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Camera> views_;
  std::size_t taken_ = 0;                   ///< views in all
  std::size_t skipped_ = 0;                 ///< lines in all
  std::vector<std::size_t> skipped_lines_;  ///< the first of them
  std::string failure_;
  bool ended_ = false, stopping_ = false;
  int stop_[2] = {-1, -1};  ///< a pipe that wakes the thread to stop it
  std::thread thread_;
};

}  // namespace ringsplat::app
