#pragma once
#include <mpi.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <ctime>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "net/collectives.hpp"

namespace ringsplat {

/// Names processes that keep others waiting. One that waits asks all others now and then; who is in a
/// collective call answers, and who is at work does by a thread, which also sees when its process makes no
/// headway. So a process that hangs in reading says so itself, and of one that does not answer the first of
/// those that wait says it.
class StallWatch {
 public:
  /// As Collectives::begin_watch(). All processes of `comm` make one.
  StallWatch(MPI_Comm comm, std::string what, const Patience& patience, bool at_work);
  ~StallWatch();
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  /// Only with this lock may MPI be called.
  std::mutex& mpi() { return mpi_; }
  /// Waits for the requests of this process's part of a collective call. Throws RunError when a process does
  /// not come and the patience says so.
  void finish(std::span<MPI_Request> requests, const char* call);

 private:
  void send(int to, int tag);
  bool take(int tag, int& from);
  void answer();
  void ask_or_tell();
  void tell();
  void watch_own_work();
  bool makes_headway(double seconds);
  [[noreturn]] void end_job();

  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  std::string what_;
  Patience patience_;
  double grace_;
  std::mutex mpi_;
  // Of the wait of this process.
  double waits_since_ = 0, ask_at_ = 0, tell_at_ = 0;
  std::vector<bool> answered_;
  // Of its work.
  std::atomic<bool> waits_{false};
  clockid_t worker_{};
  std::int64_t worker_nanoseconds_ = 0;
  double process_seconds_ = 0;
  std::uint64_t bytes_read_ = 0;
  bool stop_ = false;
  std::mutex stopping_;
  std::condition_variable stopped_;
  std::thread thread_;
};

}  // namespace ringsplat
