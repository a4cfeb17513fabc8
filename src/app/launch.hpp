#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "mpi/session.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/session/render.hpp"

namespace ringsplat::app {

/// How a piece of work ended.
struct Outcome {
  ExitCode code = ExitCode::done;
  std::string error;  ///< one line, empty when there is nothing to say
};

/// Runs `work` and turns what it throws into an outcome. The exception is gone when this returns, so
/// MPI may be called afterwards (inside a handler it may not under every MPI).
Outcome guarded(const std::function<ExitCode()>& work);

/// This process among those of the job: alone, or a rank that a launcher started.
class Launch {
 public:
  /// Initialises MPI when a launcher started this process or `choice` asks for it.
  Launch(int& argc, char**& argv, TransportChoice choice);

  int rank() const { return session_ ? session_->rank() : 0; }
  int ranks() const { return session_ ? session_->ranks() : 1; }
  bool over_mpi() const { return session_.has_value() && !in_one_process_; }
  Collectives& collectives() { return *collectives_; }
  /// Null in loopback. The first call is collective.
  Transport* transport();
  Wiring wiring(const LoopbackOptions& loopback) { return {collectives(), transport(), loopback}; }

  /// Throws InputError on all ranks when one runs another build than rank 0. Comes first of what ranks say.
  void require_same_build() const;
  /// Throws InputError on all ranks when one was told other options than rank 0.
  void require_same_options(const Facts& options);
  /// All ranks hand in an error's text or an empty one; all throw the same InputError when any has one.
  void settle(const std::string& error);
  /// `check` runs on every rank; when it throws InputError on one, all throw it.
  void check_on_all_ranks(const std::function<void()>& check);
  /// `check` runs on rank 0 only; what it throws as InputError all throw.
  void check_on_rank_0(const std::function<void()>& check);
  /// `work` runs on rank 0 only while the others wait; all get its outcome, the text on rank 0 only.
  Outcome run_on_rank_0(const std::function<ExitCode()>& work);
  /// All ranks call it when their work is done. Throws RunError on rank 0 when some have not after `seconds`:
  /// the end of MPI would wait for them for ever.
  void take_leave(double seconds);
  [[noreturn]] void abort(ExitCode code) { session_->abort(static_cast<int>(code)); }

 private:
  bool in_one_process_;
  // MPI must be there before and after what talks over it.
  std::optional<MpiSession> session_;
  std::unique_ptr<Collectives> collectives_;
  std::unique_ptr<Transport> transport_;
};

/// Where --gps auto and --renderers auto may choose from: the splits of a ring that the other options allow.
/// When neither number is given, of more ranks than `cores`, if not 0, some may be idle.
/// Throws InputError when there is nothing to choose: in one process, in a mesh, by counts that cannot be.
std::vector<Layout> layouts_to_choose_from(const RunOptions& options, bool over_mpi, int ranks,
                                           int cores = 0);

/// Which nodes the run has, from the options and the job's number of ranks (in loopback there may be any
/// number of nodes in the one process). Without options: dedicated, a third of the ranks draw; on a single
/// rank one GP and one Renderer are colocated. A mesh has as many GPs as its shape says. With
/// options.choose_roles it is the first that may be chosen. Throws InputError when the options do not fit the
/// number of ranks.
Layout choose_layout(const RunOptions& options, bool over_mpi, int ranks);

}  // namespace ringsplat::app
