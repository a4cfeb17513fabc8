#pragma once
// Several processes' collectives in one process: each is a thread.
#include <algorithm>
#include <barrier>
#include <exception>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "net/collectives.hpp"

namespace ringsplat::test {

/// What the threads share. One that ends early counts as having nothing more to say, so that the others go
/// on.
class ThreadExchange {
 public:
  explicit ThreadExchange(int processes) : barrier_(processes), mail_(std::size_t(processes)) {
    for (auto& row : mail_) row.resize(std::size_t(processes));
  }
  int processes() const { return int(mail_.size()); }
  std::vector<Block> swap(int process, std::vector<Block> out) {
    mail_[std::size_t(process)] = std::move(out);
    barrier_.arrive_and_wait();
    std::vector<Block> in;
    for (const auto& row : mail_) in.push_back(row[std::size_t(process)]);
    barrier_.arrive_and_wait();
    return in;
  }
  void leave(int process) {
    mail_[std::size_t(process)].assign(mail_.size(), {});
    barrier_.arrive_and_drop();
  }

 private:
  std::barrier<> barrier_;
  std::vector<std::vector<Block>> mail_;  ///< [from][to]
};

class ThreadCollectives final : public Collectives {
 public:
  ThreadCollectives(ThreadExchange& exchange, int process) : exchange_(exchange), process_(process) {}
  int process() const override { return process_; }
  int processes() const override { return exchange_.processes(); }
  std::vector<Block> all_to_all(std::vector<Block> out) override {
    sent_ += note(out);
    auto in = exchange_.swap(process_, std::move(out));
    note(in);
    return in;
  }
  std::vector<Block> all_gather(const Block& mine) override {
    sent_ += mine.size();
    return exchange_.swap(process_, std::vector<Block>(std::size_t(processes()), mine));
  }
  Block broadcast(Block block, int root) override {
    if (process_ == root) sent_ += block.size();
    return exchange_.swap(process_,
                          std::vector<Block>(std::size_t(processes()), std::move(block)))[std::size_t(root)];
  }
  void sum(std::span<std::uint64_t> values) override {
    const auto bytes = std::as_bytes(values);
    const auto all = all_gather(Block(bytes.begin(), bytes.end()));
    std::fill(values.begin(), values.end(), 0);
    std::vector<std::uint64_t> its(values.size(), 0);
    for (const Block& block : all) {
      std::copy(block.begin(), block.end(), std::as_writable_bytes(std::span(its)).begin());
      for (std::size_t k = 0; k < its.size(); ++k) values[k] += its[k];
    }
  }
  std::size_t sent() const { return sent_; }  ///< bytes, one for all receivers
  /// The most bytes that were sent or received in one exchange of blocks.
  std::size_t most() const { return most_; }

 private:
  std::size_t note(const std::vector<Block>& blocks) {
    std::size_t sum = 0;
    for (const Block& block : blocks) sum += block.size();
    most_ = std::max(most_, sum);
    return sum;
  }

  ThreadExchange& exchange_;
  int process_;
  std::size_t sent_ = 0, most_ = 0;
};

/// Runs `f` as so many processes. What each throws, by process; empty for one that ends well.
inline std::vector<std::string> run_as_processes(int processes,
                                                 const std::function<void(ThreadCollectives&)>& f) {
  ThreadExchange exchange(processes);
  std::vector<std::string> thrown(std::size_t(processes), std::string{});
  std::vector<std::thread> threads;
  for (int p = 0; p < processes; ++p)
    threads.emplace_back([&, p] {
      ThreadCollectives mine(exchange, p);
      try {
        f(mine);
      } catch (const std::exception& e) {
        thrown[std::size_t(p)] = e.what();
      }
      exchange.leave(p);
    });
  for (auto& thread : threads) thread.join();
  return thrown;
}

}  // namespace ringsplat::test
