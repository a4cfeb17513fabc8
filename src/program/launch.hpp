#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mpi/session.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "options/options.hpp"
#include "ringsplat/base/error.hpp"
#include "session/render.hpp"

namespace ringsplat::app {

/// This build's version and wire format, in words.
std::string build_id();

/// How a piece of work ended.
struct Outcome {
  ExitCode code = ExitCode::done;
  std::string error;  ///< one line, empty when there is nothing to say
};

/// Runs `work` and turns what it throws into an outcome. The exception is gone when this returns, so MPI may
/// be called afterwards; not every MPI allows calls inside a handler.
Outcome guarded(const std::function<ExitCode()>& work);

/// This process in its job: alone, or a rank that a launcher started.
class Launch {
 public:
  /// Initialises MPI when a launcher started this process or `choice` asks for it.
  Launch(int& argc, char**& argv, TransportChoice choice);
  /// This process alone, whatever started it.
  Launch() : in_one_process_(true), collectives_(std::make_unique<SoloCollectives>()) {}

  int rank() const { return collectives_->process(); }
  int ranks() const { return collectives_->processes(); }
  bool over_mpi() const { return session_.has_value() && !in_one_process_; }
  Collectives& collectives() { return *collectives_; }
  /// Null in loopback. The first call is collective.
  Transport* transport() {
    if (over_mpi() && !transport_) transport_ = session_->make_transport();
    return transport_.get();
  }
  Wiring wiring(const std::function<void()>& poll) { return {collectives(), transport(), {.poll = poll}}; }

  /// Throws InputError on all ranks, with both builds, when one runs another build than rank 0. Must be the
  /// ranks' first exchange.
  void require_same_build() const;
  /// Throws InputError on all ranks when one was told other options than rank 0.
  void require_same_options(const Facts& options) {
    require_same(*collectives_, options, "was started with other options",
                 "start all ranks with the same command line and --config file; only --verbose may differ");
  }
  /// Runs `check` on every rank; when one throws InputError, all throw it.
  void check_on_all_ranks(const std::function<void()>& check) { agree_after(*collectives_, check); }
  /// Runs `check` on rank 0 only; when it throws InputError, all ranks throw it.
  void check_on_rank_0(const std::function<void()>& check) {
    const std::string error = of_rank_0(rank() == 0 ? input_error_of(check) : std::string());
    if (!error.empty()) throw InputError(error);
  }
  /// What rank 0 passes, on all ranks.
  template <class T>
  T of_rank_0(const T& value) {
    return value_of<T>(collectives_->broadcast(to_bytes(value), 0), "what rank 0 decided");
  }
  /// Runs `work` on rank 0 while the others wait; all get its outcome, the text on rank 0 only.
  Outcome run_on_rank_0(const std::function<ExitCode()>& work) {
    Outcome outcome;
    if (rank() == 0) outcome = guarded(work);
    outcome.code = of_rank_0(outcome.code);
    return outcome;
  }
  /// All ranks call it when their work is done. Throws RunError when some rank has not called it
  /// when the collectives' patience is over: MPI_Finalize would wait for it for ever.
  void take_leave();
  [[noreturn]] void abort(ExitCode code) { MpiSession::abort(static_cast<int>(code)); }

 private:
  bool in_one_process_;
  // Declared first: MPI must outlive all that uses it.
  std::optional<MpiSession> session_;
  std::unique_ptr<Collectives> collectives_;
  std::unique_ptr<Transport> transport_;
};

/// Choices of --gps auto and --renderers auto: the splits of a ring that the other options allow. Some ranks
/// may be idle when neither number is given and there are more ranks than `cores` (0: no limit). Throws
/// InputError when there is nothing to choose: in one process, in a mesh, or with impossible counts.
std::vector<Layout> layouts_to_choose_from(const RunOptions& options, bool over_mpi, int ranks,
                                           int cores = 0);

/// The run's nodes, from the options and the job's number of ranks (in loopback one process hosts any number
/// of nodes). Without options each rank is GP and Renderer, those beyond `cores` (0: no limit) are idle.
/// Dedicated ones of which no number is given draw with a third of them. A mesh's shape gives its number of
/// GPs. With options.choose_roles, returns the first layout to choose from. Throws InputError when the
/// options do not fit the number of ranks.
Layout choose_layout(const RunOptions& options, bool over_mpi, int ranks, int cores = 0);

}  // namespace ringsplat::app
