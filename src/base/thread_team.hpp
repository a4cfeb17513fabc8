#pragma once
#include <functional>
#include <memory>

namespace ringsplat {

/// The threads that share one node's work. Idle ones sleep; all teams of a process use the same threads, so
/// that a team costs little until it runs.
class ThreadTeam {
 public:
  static constexpr int most_threads = 1024;

  /// The calling thread and threads − 1 more. Throws InputError for a number below 1 or above most_threads.
  explicit ThreadTeam(int threads = 1);

  int size() const { return threads_; }

  /// Calls work(lane) once for every lane 0 … lanes − 1 and returns when all have returned. At most size()
  /// lanes run at once; how many is up to the machine. A single lane runs on the calling thread. With several
  /// lanes, each flushes denormals. When a lane throws, its exception goes on to the caller (one of them, if
  /// several throw), and lanes that have not begun may be left out.
  void run(int lanes, const std::function<void(int lane)>& work);

 private:
  struct State;
  int threads_;
  std::shared_ptr<State> state_;  ///< of all copies; null when alone
};

}  // namespace ringsplat
