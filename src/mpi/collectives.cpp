#include <mpi.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <ctime>
#include <exception>
#include <fstream>
#include <mutex>
#include <numeric>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "base/clock.hpp"
#include "base/log.hpp"
#include "mpi/connections.hpp"
#include "mpi/session.hpp"
#include "net/collectives.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/mpi/communicator.hpp"

namespace ringsplat {
namespace {

/// Names processes that keep others waiting. One that waits asks all others now and then; who is in a
/// collective call answers, and who is at work does by a thread, which also sees when its process makes no
/// headway. So a process that hangs in reading says so itself, and of one that does not answer the first of
/// those that wait says it.
class StallWatch {
 public:
  /// As Collectives::begin_watch(). All processes of `comm` make one.
  StallWatch(MPI_Comm comm, std::string what, const Patience& patience, bool at_work)
      : comm_(comm),
        what_(std::move(what)),
        patience_(patience),
        grace_(std::clamp(patience.seconds / 4, 2.0, 10.0)) {
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &ranks_);
    answered_.resize(std::size_t(ranks_));
    int threads = MPI_THREAD_SINGLE;
    MPI_Query_thread(&threads);
    if (!at_work || threads < MPI_THREAD_SERIALIZED) return;
    pthread_getcpuclockid(pthread_self(), &worker_);
    thread_ = std::jthread([this](const std::stop_token& stop) { watch_own_work(stop); });
  }

  /// Only with this lock may MPI be called.
  std::mutex& mpi() { return mpi_; }
  /// Waits for the requests of this process's part of a collective call. Throws RunError when a process does
  /// not come and the patience says so.
  void finish(std::span<MPI_Request> requests, const char* call) {
    {
      const std::lock_guard lock(mpi_);
      waits_since_ = now_seconds();
      // The first that waits asks, and the others are spared.
      ask_at_ = waits_since_ + std::max(0.0, patience_.seconds - grace_) + std::min(0.1 * rank_, grace_ / 2);
      tell_at_ = never;
    }
    waits_ = true;
    for (long waits = 0;; ++waits) {
      {
        const std::lock_guard lock(mpi_);
        int done = 0;
        checked(MPI_Testall(int(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE), call);
        if (done != 0) break;
        answer();
        ask_or_tell();
      }
      const Pause pause = pause_after(waits, yields, longest_amid_frame);
      if (pause.yields) sched_yield();
      if (pause.sleeps.count() > 0) std::this_thread::sleep_for(pause.sleeps);
    }
    waits_ = false;
  }

 private:
  static constexpr int question_tag = 5, answer_tag = 6;
  static constexpr std::chrono::milliseconds tick{100};
  static constexpr long yields = 64;  // few, as ranks may share cores
  static constexpr double never = std::numeric_limits<double>::infinity();
  static constexpr const char* hint =
      "a file system may hang, or a rank's machine; --stall-timeout sets the limit";

  static std::int64_t nanoseconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
  }

  /// By this process so far, from files and others.
  static std::uint64_t bytes_read() {
    std::ifstream io("/proc/self/io");
    std::string name;
    std::uint64_t bytes = 0;
    io >> name >> bytes;
    return bytes;
  }

  void send(int to, int tag) {
    MPI_Request nobody_waits = MPI_REQUEST_NULL;
    checked(MPI_Isend(nullptr, 0, MPI_BYTE, to, tag, comm_, &nobody_waits), "MPI_Isend");
    checked(MPI_Request_free(&nobody_waits), "MPI_Request_free");
  }

  void answer() {
    while (const auto from = take_signal(comm_, MPI_ANY_SOURCE, question_tag)) {
      send(*from, answer_tag);
      if (*from < rank_ && tell_at_ == never) ask_at_ = std::max(ask_at_, now_seconds() + patience_.seconds);
    }
  }

  void ask_or_tell() {
    while (const auto from = take_signal(comm_, MPI_ANY_SOURCE, answer_tag))
      answered_[std::size_t(*from)] = true;  // also to earlier questions: it lives
    const double now = now_seconds();
    if (now > tell_at_) return tell();
    if (now < ask_at_) return;
    ask_at_ = never;
    tell_at_ = now + grace_;
    answered_.assign(std::size_t(ranks_), false);
    answered_[std::size_t(rank_)] = true;
    for (int r = 0; r < ranks_; ++r)
      if (r != rank_) send(r, question_tag);
  }

  void tell() {
    tell_at_ = never;
    std::vector<int> late;
    for (int r = 0; r < ranks_; ++r)
      if (!answered_[std::size_t(r)]) late.push_back(r);
    if (late.empty()) {
      ask_at_ = now_seconds() + patience_.seconds;
      return;
    }
    const std::string line = fmt::format("rank {} has been {} for {:.0f} s and does not answer",
                                         fmt::join(late, ", "), what_, now_seconds() - waits_since_);
    if (patience_.ends) throw RunError(line, hint);
    log_warning("{}; the others wait", line);
  }

  void watch_own_work(const std::stop_token& stop) try {
    double still = 0, last = now_seconds();
    bool told = false;
    std::mutex only_here;
    std::condition_variable_any stopped;
    for (std::unique_lock held(only_here);
         !stopped.wait_for(held, stop, tick, [&stop] { return stop.stop_requested(); });) {
      const double passed = seconds_awake(last, 10 * std::chrono::duration<double>(tick).count());
      if (waits_) {
        still = 0;
        continue;
      }
      {
        const std::lock_guard lock(mpi_);
        answer();
      }
      still = makes_headway(passed) ? 0 : still + passed;
      if (still < patience_.seconds || told) continue;
      told = true;
      const std::string line = fmt::format("rank {} has been {} for {:.0f} s", rank_, what_, still);
      if (patience_.ends) {
        log_error("{}; hint: {}", line, hint);
        const std::lock_guard lock(mpi_);
        MpiSession::abort(int(ExitCode::run_failed));
      }
      log_warning("{}; the others wait", line);
    }
  } catch (const std::exception&) {
    // MPI has failed; the process that calls it will say so.
  }

  bool makes_headway(double seconds) {
    constexpr double least_part_of_a_core = 0.05;  // threads beside the worker that only draw a bar take less
    constexpr std::uint64_t most_read_to_see = 4096;  // from /proc
    const auto worker = nanoseconds(worker_);
    const double process =
        1e-9 * double(nanoseconds(CLOCK_PROCESS_CPUTIME_ID) - nanoseconds(CLOCK_THREAD_CPUTIME_ID));
    const auto read = bytes_read();
    return std::exchange(worker_nanoseconds_, worker) != worker ||
           process - std::exchange(process_seconds_, process) > least_part_of_a_core * seconds ||
           read - std::exchange(bytes_read_, read) > most_read_to_see;
  }

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
  std::jthread thread_;  ///< last: it uses all of the above
};

constexpr int block_tag = 3;

class MpiCollectives final : public Collectives {
 public:
  MpiCollectives(MPI_Comm comm, std::size_t largest_part) : comm_(comm), largest_part_(largest_part) {}
  int process() const override { return comm_.rank(); }
  int processes() const override { return comm_.ranks(); }

  std::vector<Block> all_to_all(std::vector<Block> out) override {
    const auto peers = std::size_t(processes());
    const auto self = std::size_t(process());
    Block own = std::exchange(out[self], {});
    std::vector<std::uint64_t> out_sizes(peers), in_sizes(peers);
    for (std::size_t p = 0; p < peers; ++p) out_sizes[p] = out[p].size();
    call("MPI_Alltoall", MPI_Alltoall, MPI_Ialltoall, out_sizes.data(), 1, MPI_UINT64_T, in_sizes.data(), 1,
         MPI_UINT64_T);

    // Point to point rather than MPI_Alltoallv: its counts and displacements are `int`.
    std::vector<Block> in(peers);
    std::vector<MPI_Request> requests;
    std::unique_lock<std::mutex> calls;
    if (watch_) calls = std::unique_lock(watch_->mpi());
    for (std::size_t p = 0; p < peers; ++p) {
      in[p].resize(in_sizes[p]);
      in_parts(in[p], [&](std::byte* part, int count) {
        checked(MPI_Irecv(part, count, MPI_BYTE, int(p), block_tag, comm_.get(), &requests.emplace_back()),
                "MPI_Irecv");
      });
    }
    for (std::size_t p = 0; p < peers; ++p)
      in_parts(out[p], [&](std::byte* part, int count) {
        checked(MPI_Isend(part, count, MPI_BYTE, int(p), block_tag, comm_.get(), &requests.emplace_back()),
                "MPI_Isend");
      });
    in[self] = std::move(own);
    if (!watch_) {
      checked(MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
              "MPI_Waitall (volume exchange)");
    } else {
      calls.unlock();
      watch_->finish(requests, "MPI_Testall (volume exchange)");
    }
    return in;
  }

  std::vector<Block> all_gather(const Block& mine) override {
    const auto peers = std::size_t(processes());
    const std::uint64_t my_size = mine.size();
    std::vector<std::uint64_t> sizes(peers);
    call("MPI_Allgather", MPI_Allgather, MPI_Iallgather, &my_size, 1, MPI_UINT64_T, sizes.data(), 1,
         MPI_UINT64_T);
    std::uint64_t sum = 0;
    for (const std::uint64_t size : sizes) sum += size;
    if (sum > 0 && sum <= largest_part_) return all_gather_at_once(mine, sizes, sum);
    std::vector<Block> all(peers);
    for (std::size_t p = 0; p < peers; ++p)
      if (sizes[p] > 0) all[p] = broadcast(p == std::size_t(process()) ? mine : Block{}, int(p));
    return all;
  }

  Block broadcast(Block block, int root) override {
    std::uint64_t size = block.size();
    call("MPI_Bcast", MPI_Bcast, MPI_Ibcast, &size, 1, MPI_UINT64_T, root);
    block.resize(size);
    in_parts(block, [&](std::byte* part, int count) {
      call("MPI_Bcast", MPI_Bcast, MPI_Ibcast, part, count, MPI_BYTE, root);
    });
    return block;
  }

  void sum(std::span<std::uint64_t> values) override {
    call("MPI_Allreduce", MPI_Allreduce, MPI_Iallreduce, MPI_IN_PLACE, values.data(), int(values.size()),
         MPI_UINT64_T, MPI_SUM);
  }

  Processes part(int number) override {
    MPI_Comm comm = MPI_COMM_NULL;
    checked(MPI_Comm_split(comm_.get(), number, process(), &comm), "MPI_Comm_split");
    Processes made(comm);
    MPI_Comm_free(&comm);
    return made;
  }

  void begin_watch(const std::string& what, bool at_work) override {
    if (std::isfinite(patience.seconds)) watch_.emplace(comm_.get(), what, patience, at_work);
  }
  void end_watch() override { watch_.reset(); }

 private:
  /// Makes a collective call: the one that blocks, or with a watch the one that does not, and waits for its
  /// end.
  template <class Blocking, class Starting, class... Arguments>
  void call(const char* name, Blocking blocking, Starting start, Arguments... arguments) {
    if (!watch_) return checked(blocking(arguments..., comm_.get()), name);
    MPI_Request request = MPI_REQUEST_NULL;
    {
      const std::lock_guard lock(watch_->mpi());
      checked(start(arguments..., comm_.get(), &request), name);
    }
    watch_->finish(std::span(&request, 1), name);
  }

  /// For blocks whose `sum` fits into one message. Broadcasts from every process would need a message for
  /// each pair of processes.
  std::vector<Block> all_gather_at_once(const Block& mine, const std::vector<std::uint64_t>& sizes,
                                        std::uint64_t sum) {
    std::vector<int> counts(sizes.begin(), sizes.end()), offsets(sizes.size());
    std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
    Block joined(sum);
    call("MPI_Allgatherv", MPI_Allgatherv, MPI_Iallgatherv, mine.data(), int(mine.size()), MPI_BYTE,
         joined.data(), counts.data(), offsets.data(), MPI_BYTE);
    std::vector<Block> all;
    for (std::size_t p = 0; p < sizes.size(); ++p) {
      const auto first = joined.begin() + offsets[p];
      all.emplace_back(first, first + counts[p]);
    }
    return all;
  }

  template <class F>
  void in_parts(Block& block, F&& f) const {
    for (std::size_t at = 0; at < block.size(); at += largest_part_)
      f(block.data() + at, int(std::min(largest_part_, block.size() - at)));
  }

  OwnedComm comm_;
  std::size_t largest_part_;
  std::optional<StallWatch> watch_;
};

}  // namespace

std::unique_ptr<Collectives> make_mpi_collectives(MPI_Comm comm, std::size_t largest_part) {
  return std::make_unique<MpiCollectives>(comm, largest_part);
}

}  // namespace ringsplat
