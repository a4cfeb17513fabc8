#pragma once
#include <mpi.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <memory>
#include <optional>

#include "net/collectives.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// Throws RunError with the call's name, MPI's own words and the rank unless `code` is MPI_SUCCESS.
void checked(int code, const char* call);

/// Takes a message without a body that has come from `source`, which may be MPI_ANY_SOURCE: who sent it.
std::optional<int> take_signal(MPI_Comm comm, int source, int tag);

/// A duplicate of a communicator that returns errors instead of ending the job; freed with its owner, unless
/// MPI is already finalised.
class OwnedComm {
 public:
  explicit OwnedComm(MPI_Comm original);
  ~OwnedComm();
  OwnedComm(const OwnedComm&) = delete;
  OwnedComm& operator=(const OwnedComm&) = delete;
  MPI_Comm get() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
};

/// Largest number of bytes in one MPI message; longer ones go in parts, since counts are `int`.
inline constexpr std::size_t largest_mpi_part = std::size_t{1} << 30;

/// Both duplicate `comm` (a collective call) and return errors as exceptions (RunError). All ranks
/// must give the same `largest_part` (at least a header's size); tests use small ones. Simulated ranks have a
/// transport of their own (simulate/smpi).
std::unique_ptr<Transport> make_mpi_transport(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);
std::unique_ptr<Collectives> make_mpi_collectives(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);

/// What a rank does that has nothing to do: neither spins on.
struct Pause {
  bool yields = false;
  std::chrono::nanoseconds sleeps{0};
  bool operator==(const Pause&) const = default;
};

/// While a frame is under way a message may come at any time.
inline constexpr std::chrono::nanoseconds longest_amid_frame{200'000};

/// For the wait of that number since there was work, from 1: it spins some times, yields `yields` times, then
/// sleeps, ever longer up to `longest`.
inline Pause pause_after(long waits, long yields, std::chrono::nanoseconds longest) {
  constexpr long spins = 32, sleeps_of_a_length = 16;
  constexpr std::chrono::nanoseconds shortest{20'000};
  if (waits <= spins) return {};
  if (waits <= spins + yields) return {.yields = true};
  // A rank that has waited this long should leave its core to others.
  const long length = 1 + (waits - spins - yields) / sleeps_of_a_length, amid = longest_amid_frame / shortest;
  if (length <= amid) return {.sleeps = std::min(longest, shortest * length)};
  constexpr long most_doublings = 10;
  return {.sleeps = std::min(longest, longest_amid_frame * (1L << std::min(length - amid, most_doublings)))};
}

/// Where sleep ends when there is news.
inline constexpr std::chrono::nanoseconds longest_with_news{10'000'000};
/// Between frames only an announcement can come. It goes down a tree of the ranks (net/layout.hpp). The
/// deeper that is the less each sleeps, so that the last hears within 4 ms, but no less than amid a frame.
inline std::chrono::nanoseconds longest_between_frames(int ranks) {
  constexpr std::chrono::nanoseconds most{4'000'000}, to_the_last{4'000'000};
  const int depth = std::bit_width(static_cast<unsigned>(std::max(ranks, 1) - 1));
  return std::clamp(to_the_last / std::max(depth, 1), longest_amid_frame, most);
}

}  // namespace ringsplat
