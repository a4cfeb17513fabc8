#include <simgrid/s4u/Barrier.hpp>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "mpi/connections.hpp"

namespace ringsplat {
namespace {

/// What the ranks of a communicator give each other: in a simulation all are in one process.
struct Hands {
  simgrid::s4u::BarrierPtr meeting;
  std::vector<std::vector<Block>> given;  ///< by rank
  std::vector<std::uint64_t> sum;
};

/// Blocks go through memory, in no simulated time: reading and dealing a volume is not what is simulated, and
/// a thousand ranks would exchange a million messages for it.
class SharedCollectives final : public Collectives {
 public:
  explicit SharedCollectives(MPI_Comm comm) : comm_(comm) {
    const auto ranks = unsigned(processes());
    if (process() == 0)
      hands_ = std::make_shared<Hands>(
          Hands{simgrid::s4u::Barrier::create(ranks), std::vector<std::vector<Block>>(ranks), {}});
    auto* of_first = &hands_;
    checked(MPI_Bcast(&of_first, sizeof of_first, MPI_BYTE, 0, comm_.get()), "MPI_Bcast");
    hands_ = *of_first;
    meet();
  }
  int process() const override { return comm_.rank(); }
  int processes() const override { return comm_.ranks(); }

  std::vector<Block> all_to_all(std::vector<Block> out) override {
    return passed(std::move(out), [this](auto& from) { return std::move(from[std::size_t(process())]); });
  }
  std::vector<Block> all_gather(const Block& mine) override {
    return passed({mine}, [](const auto& from) { return from[0]; });
  }
  Block broadcast(Block block, int root) override {
    return all_gather(process() == root ? block : Block())[std::size_t(root)];
  }
  void sum(std::span<std::uint64_t> values) override {
    hands_->sum.resize(values.size());
    std::ranges::transform(values, hands_->sum, hands_->sum.begin(), std::plus());
    meet();
    std::ranges::copy(hands_->sum, values.begin());
    meet();
    hands_->sum.clear();
    meet();  // before anyone adds to the next
  }

 private:
  void meet() const { hands_->meeting->wait(); }

  /// What this rank takes of each rank's.
  template <class Take>
  std::vector<Block> passed(std::vector<Block> mine, Take take) {
    hands_->given[std::size_t(process())] = std::move(mine);
    meet();
    std::vector<Block> in;
    for (auto& from : hands_->given) in.push_back(take(from));
    meet();
    return in;
  }

  OwnedComm comm_;
  std::shared_ptr<Hands> hands_;
};

}  // namespace

std::unique_ptr<Collectives> make_mpi_collectives(MPI_Comm comm, std::size_t) {
  return std::make_unique<SharedCollectives>(comm);
}

}  // namespace ringsplat
