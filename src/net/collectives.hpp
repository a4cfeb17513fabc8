#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

using Block = Bytes;
class Processes;

/// What comes of waiting for a process that does not come to a collective call.
struct Patience {
  double seconds = std::numeric_limits<double>::infinity();  ///< until it is named
  bool ends = true;                                          ///< then the job ends; else the others wait on
};

/// Collective calls outside frames, for reading a volume and agreeing on errors. Every process must make the
/// same calls in the same order.
class Collectives {
 public:
  virtual ~Collectives() = default;
  virtual int process() const = 0;
  virtual int processes() const = 0;
  /// `out[p]` goes to process p; the result's [p] came from process p. Blocks may be larger than 2 GiB.
  virtual std::vector<Block> all_to_all(std::vector<Block> out) = 0;
  virtual std::vector<Block> all_gather(const Block& mine) = 0;
  virtual Block broadcast(Block block, int root) = 0;
  /// Adds up all processes' values, each by itself.
  virtual void sum(std::span<std::uint64_t> values) = 0;

  Patience patience;

  /// Until end_watch() processes that keep others waiting are named on stderr, as in "rank 3 has been reading
  /// head.nrrd for 30 s", where `what` is "reading head.nrrd". `at_work`: processes work between the calls,
  /// for how long nobody knows, and only who makes no headway is named. Not collective, but all make it.
  virtual void begin_watch(const std::string& /*what*/, bool /*at_work*/) {}
  virtual void end_watch() {}
  /// Connects those that give the same number, in their order; without MPI each process alone. Collective.
  virtual Processes part(int number);
  /// Watches while what it returns lives.
  [[nodiscard]] auto watched(const std::string& what, bool at_work = true) {
    begin_watch(what, at_work);
    return std::unique_ptr<Collectives, void (*)(Collectives*)>(this, [](auto* all) { all->end_watch(); });
  }
};

/// One process alone.
class SoloCollectives final : public Collectives {
 public:
  int process() const override { return 0; }
  int processes() const override { return 1; }
  std::vector<Block> all_to_all(std::vector<Block> out) override { return out; }
  std::vector<Block> all_gather(const Block& mine) override { return {mine}; }
  Block broadcast(Block block, int) override { return block; }
  void sum(std::span<std::uint64_t>) override {}
};

/// Every process hands in its error's text, or an empty one. If any is not empty, all throw the same
/// InputError: the text of the lowest process and the number of other failures.
void agree(Collectives& collectives, const std::string& my_error);

}  // namespace ringsplat
