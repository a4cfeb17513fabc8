#pragma once
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/views.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

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

  bool has_next() {
    const std::lock_guard lock(mutex_);
    return !views_.empty();
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
