#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/views.hpp"
#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

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

  /// Reads a file descriptor to its end. The descriptor and what the hooks refer to must outlive the stream.
  ViewStream(int descriptor, std::string name, const Camera& defaults, Hooks hooks);
  ~ViewStream();
  ViewStream(const ViewStream&) = delete;
  ViewStream& operator=(const ViewStream&) = delete;

  /// The next view that has arrived, if any.
  std::optional<Camera> next();
  bool has_next();
  /// True while more may come; false once the stream has ended and all views are taken.
  bool may_come();
  /// Throws InputError when lines were skipped, when no view came or when reading failed. Call it when
  /// may_come() has become false.
  void check_all_was_read();

 private:
  void read(int descriptor);
  void take_line(const LineSplitter::Line& line);
  void skip(std::size_t line, const std::string& why);
  void put(const Camera& view);

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
