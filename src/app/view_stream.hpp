#pragma once
#include <deque>
#include <iosfwd>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

/// Views that come line by line while others are rendered (`--path -`), as in a path's file but without a
/// line of names. A thread of its own waits for them.
class ViewStream {
 public:
  /// Reads a file descriptor until it ends; it must outlive the stream.
  ViewStream(int descriptor, std::string name, const Camera& defaults);
  ~ViewStream();
  ViewStream(const ViewStream&) = delete;
  ViewStream& operator=(const ViewStream&) = delete;

  /// The next view that is here. Throws InputError for a line that is no view, naming it.
  std::optional<Camera> next();
  bool has_next();
  /// True while there may be more; false once all were taken and the stream has ended.
  bool may_come();

 private:
  void read(int descriptor);
  void take_line(const std::string& line);

  std::string name_;
  Camera defaults_;
  std::mutex mutex_;
  std::deque<Camera> views_;
  std::string error_;
  int line_ = 0;
  bool ended_ = false;
  int stop_[2] = {-1, -1};  ///< a pipe that wakes the thread up to stop
  std::thread thread_;
};

}  // namespace ringsplat::app
