#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {

/// What one input may take.
struct Limits {
  double seconds = 2;                           ///< of the processor
  std::size_t memory = std::size_t{256} << 20;  ///< bytes more than before; under a sanitizer one allocation
};
/// More where a sanitizer makes everything slower and larger.
Limits usual_limits();

struct Finding {
  Input input;
  std::string what;    ///< one line: the signal, exception or limit, and where if that is known
  std::string report;  ///< what the process wrote on stderr
  /// What findings of one cause have in common: `what` without numbers.
  std::string cause() const;
};

/// Runs inputs in a child process, which may crash, hang or take all memory.
class Watch {
 public:
  explicit Watch(const Limits& limits);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  struct Batch {
    std::uint64_t inputs = 0, accepted = 0;  ///< that were run; those that were good
    std::vector<Input> novel;                ///< those that were answered as none before
    std::optional<Finding> finding;          ///< of the last one; the batch ends there
  };
  /// Runs what `next` makes, in the child process, until it makes nothing, for `seconds` at most.
  Batch run(const Driver& driver, const std::function<std::optional<Input>()>& next, double seconds = 1e9);
  /// Runs one.
  std::optional<Finding> try_one(const Driver& driver, const Input& input);

 private:
  struct Shared;
  [[noreturn]] void work(const Driver& driver, const std::function<std::optional<Input>()>& next,
                         double seconds);
  std::string judge(int status) const;

  Limits limits_;
  Shared* shared_;                   ///< with the child
  int report_;                       ///< file that the child's stderr goes to
  std::set<std::uint64_t> answers_;  ///< hashes of those seen
};

}  // namespace ringsplat::fuzz
