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

/// Limits on one input.
struct Limits {
  double seconds = 2;                           ///< processor seconds
  std::size_t memory = std::size_t{256} << 20;  ///< more bytes; under a sanitizer bytes of one allocation
};
/// The usual limits; higher under a sanitizer, which makes everything slower and larger.
Limits usual_limits();

struct Finding {
  Input input;
  std::string what;    ///< one line: the signal, exception or limit, and where if that is known
  std::string report;  ///< what the process wrote on stderr
  /// The same for all findings of one cause: `what` without numbers.
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
    std::uint64_t inputs = 0, accepted = 0;  ///< inputs run; those accepted as good
    std::vector<Input> novel;                ///< inputs with an answer not seen before
    std::optional<Finding> finding;          ///< the last input's; the batch ends there
  };
  /// Runs the inputs from `next` in a child process until there are no more, for at most `seconds`.
  Batch run(const Driver& driver, const std::function<std::optional<Input>()>& next, double seconds = 1e9);
  /// Runs one input.
  std::optional<Finding> try_one(const Driver& driver, const Input& input);

 private:
  struct Shared;
  [[noreturn]] void work(const Driver& driver, const std::function<std::optional<Input>()>& next,
                         double seconds);
  std::string judge(int status) const;

  Limits limits_;
  Shared* shared_;                   ///< shared with the child
  int report_;                       ///< file that the child's stderr goes to
  std::set<std::uint64_t> answers_;  ///< hashes of answers seen
};

}  // namespace ringsplat::fuzz
