// main() of Catch2 programs that run on several ranks: tests are collective, every rank runs the same ones in
// the same order.
#define CATCH_CONFIG_RUNNER
#include "support/catch.hpp"

#include <mpi.h>

#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

constexpr int failed_assertion = 1;

std::string who_am_i() {
  int rank = -1, ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return "rank " + std::to_string(rank) + " of " + std::to_string(ranks);
}

// A rank that fails and goes on leaves the others waiting in the next collective call for ever.
#if CATCH_VERSION_MAJOR == 2
using ListenerBase = Catch::TestEventListenerBase;
#else
using ListenerBase = Catch::EventListenerBase;
#endif

class AbortOnFailure : public ListenerBase {
 public:
  using ListenerBase::ListenerBase;

  void testCaseStarting(const Catch::TestCaseInfo& test) override {
    ListenerBase::testCaseStarting(test);
    test_ = test.name;
  }

#if CATCH_VERSION_MAJOR == 2
  bool assertionEnded(const Catch::AssertionStats& stats) override {
    abort_if_failed(stats);
    return true;
  }
#else
  void assertionEnded(const Catch::AssertionStats& stats) override { abort_if_failed(stats); }
#endif

 private:
  void abort_if_failed(const Catch::AssertionStats& stats) const {
    const auto& result = stats.assertionResult;
    if (result.isOk()) return;
    std::ostringstream text;
    text << "\nFAILED on " << who_am_i() << ", in \"" << test_ << "\"\n" << result.getSourceInfo() << "\n";
    if (result.hasExpression()) text << "  " << result.getExpressionInMacro() << "\n";
    if (result.hasExpandedExpression())
      text << "with expansion:\n  " << result.getExpandedExpression() << "\n";
    if (result.hasMessage()) text << "  " << result.getMessage() << "\n";
    for (const auto& message : stats.infoMessages) text << "  " << message.message << "\n";
    std::cerr << text.str() << std::flush;
    MPI_Abort(MPI_COMM_WORLD, failed_assertion);
  }

  std::string test_;
};
CATCH_REGISTER_LISTENER(AbortOnFailure)

int run(int argc, char** argv, int rank) {
  std::vector<const char*> arguments(argv, argv + argc);
  // The same random numbers on every rank and in every run, unless the command line (which comes later) says
  // otherwise.
  arguments.insert(arguments.begin() + 1, {"--rng-seed", "1"});
  if (rank != 0) arguments.insert(arguments.end(), {"--out", "/dev/null"});
  Catch::Session session;
  const int usage = session.applyCommandLine(int(arguments.size()), arguments.data());
  return usage != 0 ? usage : session.run();
}

}  // namespace

int main(int argc, char** argv) {
  int thread_level = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &thread_level);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const int code = run(argc, argv, rank);
  MPI_Finalize();
  return code;
}
