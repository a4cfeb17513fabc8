#include "base/thread_team.hpp"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <optional>

#include "base/process.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// TBB orders lanes and their caller by fences that ThreadSanitizer does not see; it sees these. They do not
/// order lanes with each other: that would hide races between lanes. All teams share them, because a lane
/// could find its own team's only through memory that is still to be ordered.
std::atomic<unsigned> begun = 0, ended = 0;

/// The caller's earlier work happens before the lanes', and theirs before its later work.
struct CallerOrder {
  CallerOrder() { begun.fetch_add(1, std::memory_order_release); }
  ~CallerOrder() { static_cast<void>(ended.load(std::memory_order_acquire)); }
};

struct LaneOrder {
  LaneOrder() { static_cast<void>(begun.load(std::memory_order_acquire)); }
  ~LaneOrder() { ended.fetch_add(1, std::memory_order_release); }
};

}  // namespace

struct ThreadTeam::State {
  explicit State(int threads) : arena(threads) {
    // TBB starts no more threads than there are cores unless it is told to; a program's own limit stays.
    constexpr auto parallelism = tbb::global_control::max_allowed_parallelism;
    if (tbb::global_control::active_value(parallelism) < std::size_t(threads))
      limit.emplace(parallelism, std::size_t(threads));
  }
  std::optional<tbb::global_control> limit;
  tbb::task_arena arena;
};

ThreadTeam::ThreadTeam(int threads) : threads_(threads) {
  if (threads < 1 || threads > most_threads)
    throw InputError(
        fmt::format("{} threads cannot share a rank's work", threads),
        fmt::format("--threads-per-rank takes 1 to {}; one for each core of a rank is best", most_threads));
  if (threads > 1) state_ = std::make_shared<State>(threads);
}

void ThreadTeam::run(int lanes, const std::function<void(int lane)>& work) {
  if (lanes <= 1 || !state_) {
    for (int lane = 0; lane < lanes; ++lane) work(lane);
    return;
  }
  const auto one = [&](int lane) {
    const LaneOrder order;
    flush_denormals();
    work(lane);
  };
  const CallerOrder order;
  // Static: a lane tends to meet the same thread again, whose cache has its buffers.
  state_->arena.execute([&] { tbb::parallel_for(0, lanes, one, tbb::static_partitioner()); });
}

}  // namespace ringsplat
