#pragma once
#include <stdexcept>
#include <string>

namespace ringsplat {

/// The process's exit codes (docs/faults.md, "Exit codes").
enum class ExitCode : int { done = 0, comparison_failed = 1, bad_input = 2, run_failed = 3 };

/// An error for people: `what()` is one line "WHAT IS WRONG, WHERE; hint: WHAT TO DO".
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& problem, const std::string& hint)
      : std::runtime_error(hint.empty() ? problem : problem + "; hint: " + hint), code_(code) {}
  ExitCode exit_code() const { return code_; }

 private:
  ExitCode code_;
};

/// Wrong usage or bad input, exit code 2. Found before the first frame, except in views from stdin and
/// in later volumes of a series.
struct InputError : Error {
  InputError(const std::string& problem, const std::string& hint = {})
      : Error(ExitCode::bad_input, problem, hint) {}
};

/// A failure while running (a rank, MPI, the disk, a broken protocol), exit code 3.
struct RunError : Error {
  RunError(const std::string& problem, const std::string& hint = {})
      : Error(ExitCode::run_failed, problem, hint) {}
};

}  // namespace ringsplat
