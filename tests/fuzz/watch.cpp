#include "fuzz/watch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <typeinfo>
#include <utility>

#include "fuzz/mutate.hpp"
#include "ringsplat/base/error.hpp"

#if defined(__SANITIZE_ADDRESS__)
#define RINGSPLAT_FUZZ_SANITIZED 1
#else
#define RINGSPLAT_FUZZ_SANITIZED 0
#endif

namespace ringsplat::fuzz {
namespace {

constexpr bool sanitized = RINGSPLAT_FUZZ_SANITIZED != 0;
constexpr int crashed_with_report = 99;  ///< a sanitizer's exit code, see default_options.cpp
constexpr std::size_t most_novel_bytes = std::size_t{1} << 20, longest_problem = 4096;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Ends this process by SIGPROF after that many processor seconds, or by SIGALRM when it only waits.
void set_alarms(double seconds) {
  const auto timer = [](double s) {
    itimerval t{};
    t.it_value.tv_sec = static_cast<time_t>(s);
    t.it_value.tv_usec = static_cast<suseconds_t>((s - double(t.it_value.tv_sec)) * 1e6);
    return t;
  };
  constexpr double longest_wait = 10;  // factor on processor seconds, since other programs run meanwhile
  const itimerval processor = timer(seconds), wall = timer(longest_wait * seconds);
  setitimer(ITIMER_PROF, &processor, nullptr);
  setitimer(ITIMER_REAL, &wall, nullptr);
}

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::size_t(usage.ru_maxrss) << 10;
}

std::size_t address_space() {
  std::ifstream in("/proc/self/statm");
  std::size_t pages = 0;
  in >> pages;
  return pages * std::size_t(sysconf(_SC_PAGESIZE));
}

/// An answer without its numbers.
std::string without_numbers(const std::string& text) {
  std::string kept;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "0x") == 0) {
      while (i + 1 < text.size() && std::isxdigit(static_cast<unsigned char>(text[i + 1])) != 0) ++i;
      ++i;
    } else if (std::isdigit(static_cast<unsigned char>(text[i])) == 0) {
      kept += text[i];
    }
  }
  return kept;
}

/// Hash of an answer without numbers and without its quotes of the input, which may contain quotation marks.
std::uint64_t hash_of_answer(const std::string& text) {
  std::string kept = without_numbers(text);
  const auto first = kept.find_first_of("'\""), last = kept.find_last_of("'\"");
  if (first != std::string::npos) kept.erase(first, last + 1 - first);
  kept.erase(std::remove_if(kept.begin(), kept.end(),
                            [](unsigned char c) { return std::isalpha(c) == 0 && c != ' '; }),
             kept.end());
  return std::hash<std::string>{}(kept);
}

bool says_out_of_memory(const std::string& text) {
  return text.find("bad_alloc") != std::string::npos ||
         text.find("needs more memory than there is") != std::string::npos;
}

struct Answer {
  std::string text;     ///< the error, or empty
  std::string problem;  ///< set when no input should get this answer
};

Answer answer_of(const Driver& driver, std::span<const std::byte> input) {
  try {
    driver.run(input);
  } catch (const Error& e) {
    if (says_out_of_memory(e.what()))
      return {e.what(), fmt::format("more memory than allowed: {}", e.what())};
    return {e.what(), {}};
  } catch (const std::exception& e) {
    return {e.what(), fmt::format("{}: {}", typeid(e).name(), e.what())};
  } catch (...) {
    return {{}, "an exception that is none of the standard library's"};
  }
  return {};
}

/// The line of a sanitizer's or the C library's report that says what happened, and the first place in this
/// project's files.
std::string gist_of(const std::string& report) {
  std::string gist, place;
  for (std::size_t at = 0; at < report.size();) {
    const std::size_t end = std::min(report.find('\n', at), report.size());
    const std::string line = report.substr(at, end - at);
    at = end + 1;
    for (const char* sign : {"ERROR: ", "runtime error: ", "Assertion ", "terminate called", "corrupted"})
      if (const auto found = line.find(sign); gist.empty() && found != std::string::npos)
        gist = line.substr(std::string(sign) == "ERROR: " ? found : 0, 200);
    const auto source = line.find("/src/");
    if (place.empty() && source != std::string::npos && line.find("#") != std::string::npos)
      place = line.substr(source + 1);
  }
  return place.empty() ? gist : fmt::format("{} at {}", gist, place);
}

}  // namespace

Limits usual_limits() { return sanitized ? Limits{20, std::size_t{512} << 20} : Limits{}; }

std::string Finding::cause() const { return without_numbers(what); }

/// Memory shared with the child, which remains when the child crashes.
struct Watch::Shared {
  std::uint64_t done = 0, accepted = 0;  ///< inputs answered correctly; those accepted as good
  std::size_t size = 0;                  ///< of `input`
  std::size_t novel_bytes = 0;
  char input[longest_input];      ///< the input being run
  char problem[longest_problem];  ///< the input's problem, if the child itself found one
  char novel[most_novel_bytes];   ///< parts, each an answer's hash and its input
};

Watch::Watch(const Limits& limits) : limits_(limits) {
  void* const memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  std::string name = (scratch() / "stderr-XXXXXX").string();
  report_ = mkstemp(name.data());
  if (memory == MAP_FAILED || report_ < 0)
    throw std::runtime_error("no memory or file to share with a child");
  shared_ = static_cast<Shared*>(memory);
}

Watch::~Watch() {
  munmap(shared_, sizeof(Shared));
  close(report_);
}

Watch::Batch Watch::run(const Driver& driver, const std::function<std::optional<Input>()>& next,
                        double seconds) {
  shared_->done = shared_->accepted = 0;
  shared_->size = shared_->novel_bytes = 0;
  shared_->problem[0] = '\0';
  if (ftruncate(report_, 0) != 0) throw std::runtime_error("the report cannot be emptied");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process can be made");
  if (child == 0) work(driver, next, seconds);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  Batch batch;
  batch.inputs = shared_->done;
  batch.accepted = shared_->accepted;
  auto novel =
      std::span<const std::byte>(reinterpret_cast<const std::byte*>(shared_->novel), shared_->novel_bytes);
  std::span<const std::byte> part;
  while (take_part(novel, part)) {
    std::uint64_t hash = 0;
    std::memcpy(&hash, part.data(), sizeof hash);
    answers_.insert(hash);
    batch.novel.emplace_back(text_of(part.subspan(sizeof hash)));
  }
  if (status == 0) return batch;
  ++batch.inputs;
  std::string report(std::size_t(lseek(report_, 0, SEEK_END)), '\0');
  report.resize(std::size_t(std::max<ssize_t>(0, pread(report_, report.data(), report.size(), 0))));
  batch.finding = Finding{Input(shared_->input, shared_->size), {}, std::move(report)};
  batch.finding->what = judge(status);
  if (const std::string gist = gist_of(batch.finding->report); !gist.empty())
    batch.finding->what += fmt::format("{}{}", batch.finding->what.empty() ? "" : ": ", gist);
  return batch;
}

std::string Watch::judge(int status) const {
  if (shared_->problem[0] != '\0') return shared_->problem;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF)
    return fmt::format("more than {} s of the processor's time", limits_.seconds);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return "waits for something that does not come";
  if (WIFSIGNALED(status)) return strsignal(WTERMSIG(status));
  if (WEXITSTATUS(status) == crashed_with_report) return {};
  return fmt::format("the process ended itself with exit code {}", WEXITSTATUS(status));
}

std::optional<Finding> Watch::try_one(const Driver& driver, const Input& input) {
  bool given = false;
  return run(driver,
             [&]() -> std::optional<Input> {
               if (std::exchange(given, true)) return {};
               return input;
             })
      .finding;
}

void Watch::work(const Driver& driver, const std::function<std::optional<Input>()>& next, double seconds) {
  // Reading stdin waits, as at a terminal. stdout is discarded: drivers have no results.
  int silent[2];
  const int nothing = open("/dev/null", O_WRONLY);
  if (pipe(silent) != 0 || nothing < 0) _exit(1);
  dup2(silent[0], STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  dup2(report_, STDERR_FILENO);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (!sanitized) {
    // Generous, because memory that is allocated but never touched does not count.
    const rlim_t most = address_space() + 8 * limits_.memory;
    const rlimit space{most, most};
    setrlimit(RLIMIT_AS, &space);
  }
  const double begun = seconds_now();
  while (seconds_now() - begun < seconds) {
    const std::optional<Input> input = next();
    if (!input) break;
    std::memcpy(shared_->input, input->data(), shared_->size = std::min(input->size(), longest_input));
    const std::size_t before = peak_bytes();
    set_alarms(limits_.seconds);
    Answer answer = answer_of(driver, std::span(bytes_of_input(*input)));
    set_alarms(0);
    // A sanitizer's own memory grows with every allocation, so there single allocations are limited instead.
    if (answer.problem.empty() && !sanitized && peak_bytes() > before + limits_.memory)
      answer.problem = fmt::format("{} MiB of memory ({})", (peak_bytes() - before) >> 20, answer.text);
    if (!answer.problem.empty()) {
      std::snprintf(shared_->problem, longest_problem, "%s", answer.problem.c_str());
      _exit(1);
    }
    ++shared_->done;
    shared_->accepted += answer.text.empty();
    const std::uint64_t hash = hash_of_answer(answer.text);
    if (answer.text.empty() || !answers_.insert(hash).second) continue;
    Input novel(reinterpret_cast<const char*>(&hash), sizeof hash);
    novel += *input;
    Input part;
    append_part(part, bytes_of_input(novel));
    if (part.size() > most_novel_bytes - shared_->novel_bytes) continue;
    std::memcpy(shared_->novel + shared_->novel_bytes, part.data(), part.size());
    shared_->novel_bytes += part.size();
  }
  _exit(0);
}

}  // namespace ringsplat::fuzz
