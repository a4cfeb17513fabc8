// Runs decoders on damaged inputs:  fuzz [DRIVER...] [--inputs N | --seconds S] [--seed K] [--keep FOLDER]
//                                    fuzz DRIVER --replay FILE... | --here FILE | --list
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <map>

#include "formats/files.hpp"
#include "fuzz/mutate.hpp"
#include "fuzz/watch.hpp"

using namespace ringsplat::fuzz;
namespace fs = std::filesystem;
using files::slurp;

namespace {

struct Options {
  std::vector<std::string> names;
  int inputs = 0;  ///< inputs for each driver; 0: as many as in its short run
  double seconds = 0;
  std::uint64_t seed = 1;
  std::string keep = "fuzz-found";
  std::vector<std::string> replay;
  std::string here;
  bool list = false;
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Input> files_in(const fs::path& folder) {
  std::vector<fs::path> paths;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Input> inputs;
  for (const auto& path : paths) inputs.push_back(slurp(path));
  return inputs;
}

/// Removes parts that the finding does not need, in a limited number of attempts.
Input shorten(Watch& watch, const Driver& driver, const Finding& finding) {
  Input least = finding.input;
  int attempts = 200;
  for (std::size_t part = std::max<std::size_t>(least.size() / 2, 1); attempts > 0; part /= 2) {
    for (std::size_t at = 0; at < least.size() && attempts > 0; --attempts) {
      Input shorter = least;
      shorter.erase(at, part);
      const auto same = watch.try_one(driver, shorter);
      if (same && same->cause() == finding.cause())
        least = std::move(shorter);
      else
        at += part;
    }
    if (part <= 1) break;
  }
  return least;
}

/// One driver's run: its seeds and crashes unchanged, then mutations of them.
class Campaign {
 public:
  Campaign(const Driver& driver, const Options& options)
      : driver_(driver), options_(options), watch_(usual_limits()) {
    for (const auto& more :
         {files_in(fs::path(RINGSPLAT_FUZZ_FILES) / "crashes" / driver.name),
          files_in(fs::path(RINGSPLAT_FUZZ_FILES) / "seeds" / driver.name), driver.seeds()})
      corpus_.insert(corpus_.end(), more.begin(), more.end());
  }

  /// Returns the number of causes found.
  std::size_t run() {
    std::size_t next = 0;
    while (next < corpus_.size()) {
      auto at = next;
      const auto batch = watch_.run(driver_, [&]() -> std::optional<Input> {
        if (at == corpus_.size()) return {};
        return corpus_[at++];
      });
      next += batch.inputs;
      take(batch, false);
    }
    const std::size_t kept = corpus_.size();
    const std::uint64_t wanted =
        options_.seconds > 0 ? ~std::uint64_t{0}
                             : std::uint64_t(options_.inputs > 0 ? options_.inputs : driver_.short_inputs);
    const double until = seconds_now() + (options_.seconds > 0 ? options_.seconds : 1e9);
    constexpr std::size_t most_findings = 200;
    for (std::uint64_t number = 0, made = 0; made < wanted && seconds_now() < until; ++number) {
      Mutator mutator(options_.seed * 1'000'003 + number, driver_.words);
      std::uint64_t left = std::min<std::uint64_t>(inputs_a_batch, wanted - made);
      const auto batch = watch_.run(
          driver_,
          [&]() -> std::optional<Input> {
            if (left-- == 0) return {};
            return mutator.next(corpus_);
          },
          until - seconds_now());
      made += std::max<std::uint64_t>(batch.inputs, 1);
      take(batch, true);
      if (findings_ >= most_findings) break;
    }
    fmt::print(
        "{:17} {:9} inputs of {} seeds, {} accepted, {} kept for a new answer, {} findings of {} causes\n",
        driver_.name, inputs_, kept, accepted_, corpus_.size() - kept, findings_, causes_.size());
    std::fflush(stdout);
    return causes_.size();
  }

 private:
  static constexpr std::uint64_t inputs_a_batch = 2000;

  void take(const Watch::Batch& batch, bool keep_novel) {
    inputs_ += batch.inputs;
    accepted_ += batch.accepted;
    constexpr std::size_t most_kept = 2000;  // answers that quote the input are always new
    if (keep_novel && corpus_.size() < most_kept)
      corpus_.insert(corpus_.end(), batch.novel.begin(), batch.novel.end());
    if (!batch.finding) return;
    ++findings_;
    Finding finding = *batch.finding;
    if (++causes_[finding.cause()] > 1) return;
    finding.input = shorten(watch_, driver_, finding);
    const fs::path folder = fs::absolute(fs::path(options_.keep) / driver_.name);
    fs::create_directories(folder);
    const fs::path file =
        folder / fmt::format("{:016x}", std::hash<std::string>{}(std::string(finding.input)));
    std::ofstream(file, std::ios::binary) << finding.input;
    std::ofstream(file.string() + ".report", std::ios::binary) << finding.what << '\n' << finding.report;
    fmt::print("{}: {}\n  {} {} --replay {}\n", driver_.name, finding.what,
               fs::read_symlink("/proc/self/exe").string(), driver_.name, file.string());
    std::fflush(stdout);
  }

  const Driver& driver_;
  const Options& options_;
  Watch watch_;
  std::vector<Input> corpus_;
  std::uint64_t inputs_ = 0, accepted_ = 0;
  std::size_t findings_ = 0;
  std::map<std::string, int> causes_;
};

std::vector<const Driver*> chosen_drivers(const Options& options) {
  std::vector<const Driver*> chosen;
  for (const Driver& driver : drivers())
    if (options.names.empty() ||
        std::find(options.names.begin(), options.names.end(), driver.name) != options.names.end())
      chosen.push_back(&driver);
  return chosen;
}

int replay(const Driver& driver, const Options& options) {
  Watch watch(usual_limits());
  int found = 0;
  for (const auto& file : options.replay) {
    const auto finding = watch.try_one(driver, slurp(file));
    fmt::print("{}: {}\n", file, finding ? finding->what : "fine");
    if (!finding) continue;
    fmt::print("{}", finding->report);
    found = 1;
  }
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App program(
      "Runs decoders on damaged inputs, each batch in a process of its own. Exits with 1 when one "
      "crashes, hangs, takes too much memory or throws what it should not.");
  program.add_option("DRIVER", options.names, "Decoders; all when none is named");
  program.add_option("--inputs", options.inputs, "Inputs for each driver [those of the short run]");
  program.add_option("--seconds", options.seconds, "Or so long for each");
  program.add_option("--seed", options.seed, "Of the random numbers");
  program.add_option("--keep", options.keep, "Folder for inputs that were found");
  program.add_option("--replay", options.replay, "Files to run instead");
  program.add_option("--here", options.here, "A file to run in this very process, for a debugger");
  program.add_flag("--list", options.list, "Name the drivers");
  CLI11_PARSE(program, argc, argv);
  const auto chosen = chosen_drivers(options);
  if (chosen.empty() || (!options.names.empty() && chosen.size() != options.names.size())) {
    fmt::print(stderr, "a driver is unknown; --list names them\n");
    return 2;
  }
  if (options.list) {
    for (const Driver* driver : chosen) fmt::print("{}\n", driver->name);
    return 0;
  }
  scratch();  // created here, so that no child creates its own
  if (!options.here.empty()) {
    chosen.front()->run(bytes_of_input(slurp(options.here)));
    return 0;
  }
  if (!options.replay.empty()) return replay(*chosen.front(), options);
  std::size_t causes = 0;
  for (const Driver* driver : chosen) causes += Campaign(*driver, options).run();
  return causes > 0 ? 1 : 0;
}
