#pragma once
#include <vector>

#include "fuzz/driver.hpp"
#include "net/collectives.hpp"

namespace ringsplat::fuzz {

/// Process 0 or 1 of two. The other one sends an input's parts in order, then nothing.
class OtherProcess final : public Collectives {
 public:
  OtherProcess(int process, std::span<const std::byte> parts) : process_(process), parts_(parts) {}
  int process() const override { return process_; }
  int processes() const override { return 2; }
  std::vector<Block> all_to_all(std::vector<Block> out) override {
    sent.insert(sent.end(), out.begin(), out.end());
    out[std::size_t(1 - process_)] = next();
    return out;
  }
  std::vector<Block> all_gather(const Block& mine) override {
    std::vector<Block> all(2, mine);
    all[std::size_t(1 - process_)] = next();
    return all;
  }
  Block broadcast(Block block, int root) override {
    sent.push_back(block);
    return root == process_ ? block : next();
  }
  void sum(std::span<std::uint64_t>) override {}

  std::vector<Block> sent;  ///< sent by all_to_all and broadcast

 private:
  Block next() {
    std::span<const std::byte> part;
    if (!take_part(parts_, part)) return {};
    return {part.begin(), part.end()};
  }

  int process_;
  std::span<const std::byte> parts_;
};

}  // namespace ringsplat::fuzz
