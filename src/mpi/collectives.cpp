#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <thread>

#include "base/clock.hpp"
#include "mpi/connections.hpp"
#include "mpi/stall_watch.hpp"

namespace ringsplat {
namespace {

constexpr int block_tag = 3, presence_tag = 4;

class MpiCollectives final : public Collectives {
 public:
  MpiCollectives(MPI_Comm comm, std::size_t largest_part) : comm_(comm), largest_part_(largest_part) {}
  int process() const override { return comm_.rank(); }
  int processes() const override { return comm_.ranks(); }

  std::vector<Block> all_to_all(std::vector<Block> out) override {
    const auto peers = static_cast<std::size_t>(processes());
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
      if (p == static_cast<std::size_t>(process()))
        in[p] = std::move(out[p]);
      else
        in_parts(in[p], [&](std::byte* part, int count) {
          checked(MPI_Irecv(part, count, MPI_BYTE, static_cast<int>(p), block_tag, comm_.get(),
                            &requests.emplace_back()),
                  "MPI_Irecv");
        });
    }
    for (std::size_t p = 0; p < peers; ++p) {
      if (p == static_cast<std::size_t>(process())) continue;
      in_parts(out[p], [&](std::byte* part, int count) {
        checked(MPI_Isend(part, count, MPI_BYTE, static_cast<int>(p), block_tag, comm_.get(),
                          &requests.emplace_back()),
                "MPI_Isend");
      });
    }
    if (!watch_) {
      checked(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
              "MPI_Waitall (volume exchange)");
    } else {
      calls.unlock();
      watch_->finish(requests, "MPI_Testall (volume exchange)");
    }
    return in;
  }

  std::vector<Block> all_gather(const Block& mine) override {
    const auto peers = static_cast<std::size_t>(processes());
    const std::uint64_t my_size = mine.size();
    std::vector<std::uint64_t> sizes(peers);
    call("MPI_Allgather", MPI_Allgather, MPI_Iallgather, &my_size, 1, MPI_UINT64_T, sizes.data(), 1,
         MPI_UINT64_T);
    std::uint64_t sum = 0;
    for (const std::uint64_t size : sizes) sum += size;
    if (sum > 0 && sum <= largest_part_) return all_gather_at_once(mine, sizes, sum);
    std::vector<Block> all(peers);
    for (std::size_t p = 0; p < peers; ++p)
      if (sizes[p] > 0)
        all[p] = broadcast(p == static_cast<std::size_t>(process()) ? mine : Block{}, static_cast<int>(p));
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

  std::vector<int> absent(double seconds) override {
    if (process() != 0) {
      checked(MPI_Send(nullptr, 0, MPI_BYTE, 0, presence_tag, comm_.get()), "MPI_Send");
      return {};
    }
    std::vector<int> missing(std::size_t(processes()) - 1);
    std::iota(missing.begin(), missing.end(), 1);
    const double until = now_seconds() + seconds;
    while (true) {
      // Reads the clock before it looks, so that answers that came while this process had no core still
      // count.
      const bool late = now_seconds() > until;
      // One receive for each process: a fast one may already have sent its message for the next call.
      std::erase_if(missing, [this](int p) { return take_signal(comm_.get(), p, presence_tag).has_value(); });
      if (missing.empty() || late) return missing;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  void begin_watch(const std::string& what, bool at_work) override {
    if (std::isfinite(patience().seconds)) watch_.emplace(comm_.get(), what, patience(), at_work);
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
    call("MPI_Allgatherv", MPI_Allgatherv, MPI_Iallgatherv, mine.data(), static_cast<int>(mine.size()),
         MPI_BYTE, joined.data(), counts.data(), offsets.data(), MPI_BYTE);
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
      f(block.data() + at, static_cast<int>(std::min(largest_part_, block.size() - at)));
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
