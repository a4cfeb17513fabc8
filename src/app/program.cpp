#include <signal.h>

#include "app/commands.hpp"
#include "base/lack_of_memory.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "command_line/command_line.hpp"
#include "program/launch.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {
namespace {

ExitCode run(const Say& o) { return write_text_output("-", o.text), ExitCode::done; }
ExitCode run(const std::monostate&) { return ExitCode::bad_input; }

/// Of subcommands that all ranks run.
template <class Options>
constexpr bool is_collective = requires(const Options& o, Launch& launch) {
  run(o, launch);
};

/// An outcome, and whether all ranks know it or only the one that failed.
struct Ending {
  Outcome outcome;
  bool on_all_ranks;
};

Ending dispatch(const CommandLine& line, Launch& launch) {
  // Ranks must agree before they go on: they may be of different builds, be started differently, or lack the
  // --config file on some machines.
  const Outcome agreed = guarded([&] {
    launch.require_same_build();
    agree(launch.collectives(), line.error);
    launch.require_same_options(line.options);
    return ExitCode::done;
  });
  if (agreed.code != ExitCode::done) return {agreed, agreed.code == ExitCode::bad_input};
  const auto visit = [&]<class Options>(const Options& o) -> Ending {
    if constexpr (is_collective<Options>) {
      Outcome outcome = guarded([&] { return run(o, launch); });
      const bool everywhere = outcome.code != ExitCode::run_failed;
      return {std::move(outcome), everywhere};
    } else {
      return {launch.run_on_rank_0([&] { return run(o); }), true};
    }
  };
  return std::visit(visit, line.command);
}

/// With rank 0's number if wanted, which its lines do not have.
void say_error(const Outcome& outcome, bool name_rank_0 = false) {
  if (outcome.error == lack_of_memory)
    say_lack_of_memory();
  else
    log_error("{}{}", name_rank_0 && !outcome.error.starts_with("rank ") ? "rank 0: " : "", outcome.error);
}

ExitCode finish(const Ending& ending, Launch& launch) {
  const auto& [outcome, on_all_ranks] = ending;
  if (!outcome.error.empty() && (launch.rank() == 0 || !on_all_ranks))
    say_error(outcome, !on_all_ranks && launch.ranks() > 1 && launch.rank() == 0);
  if (!on_all_ranks && launch.ranks() > 1) launch.abort(outcome.code);
  return outcome.code;
}

/// Returns `code`, or run_failed when some output could not be written. A run that has already failed keeps
/// its own message.
ExitCode after_printing(ExitCode code) {
  if (code == ExitCode::run_failed) return code;
  const Outcome printed = guarded([] {
    flush_stdout();
    return ExitCode::done;
  });
  if (printed.code == ExitCode::done) return code;
  say_error(printed);
  return printed.code;
}

TransportChoice transport_of(const CommandLine& line) {
  if (const auto* serve = std::get_if<ServeOptions>(&line.command)) return serve->picture.run.transport;
  const auto* render = std::get_if<RenderOptions>(&line.command);
  return render != nullptr ? render->run.transport : TransportChoice::automatic;
}

}  // namespace

int run_program(int argc, char** argv) {
  signal(SIGXFSZ, SIG_IGN);  // a file over the file size limit is a write error
  keep_standard_descriptors();
  prefer_huge_pages_in_heap();
  std::optional<CommandLine> line;
  std::optional<Launch> launch;
  const Outcome started = guarded([&] {
    line.emplace(parse_command_line(argc, argv, MpiSession::library()));
    launch.emplace(argc, argv, transport_of(*line));
    set_log_rank(launch->rank(), line->verbose);
    for (const std::string& note : line->notes) log_warning_once("{}", note);
    return ExitCode::done;
  });
  if (started.code != ExitCode::done) {
    say_error(started);
    return static_cast<int>(started.code);
  }
  return static_cast<int>(after_printing(finish(dispatch(*line, *launch), *launch)));
}

}  // namespace ringsplat::app
