#include "base/child_program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <system_error>
#include <thread>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"

extern char** environ;

namespace ringsplat {
namespace {

/// The folder, what stays open, and the signals of a program that is started. None of the job's connections
/// may live on in it.
class Surroundings {
 public:
  Surroundings(const std::filesystem::path& folder, const std::vector<int>& descriptors) {
    posix_spawn_file_actions_init(&files_);
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_addchdir_np(&files_, folder.c_str());
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files_, STDOUT_FILENO, STDERR_FILENO);
    const int first = STDERR_FILENO + 1, end = first + int(descriptors.size());
    // Copies above all of their new numbers, so that none takes another's place.
    for (const int descriptor : descriptors) copies_.push_back(::fcntl(descriptor, F_DUPFD_CLOEXEC, end));
    for (std::size_t k = 0; k < copies_.size(); ++k)
      posix_spawn_file_actions_adddup2(&files_, copies_[k], first + int(k));
    posix_spawn_file_actions_addclosefrom_np(&files_, end);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  }
  ~Surroundings() {
    for (const int copy : copies_) ::close(copy);
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;

  const posix_spawn_file_actions_t* files() const { return &files_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  std::vector<int> copies_;
  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
};

}  // namespace

bool is_program(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* const folders = std::getenv("PATH");
  for (const auto folder : detail::split(folders == nullptr ? "" : folders, ":")) {
    const std::filesystem::path program = std::filesystem::path(folder) / name;
    if (program.is_absolute() && is_program(program)) return program;
  }
  return std::nullopt;
}

pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder, const std::vector<int>& descriptors) {
  std::vector<char*> all{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) all.push_back(const_cast<char*>(argument.c_str()));
  all.push_back(nullptr);
  const Surroundings surroundings(folder, descriptors);
  pid_t child = 0;
  const int error = posix_spawn(&child, program.c_str(), surroundings.files(), surroundings.attributes(),
                                all.data(), environ);
  if (error != 0)
    throw RunError(
        fmt::format("{} cannot be started: {}", program.string(), std::generic_category().message(error)));
  return child;
}

std::optional<int> run_program(const std::filesystem::path& program,
                               const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                               std::chrono::steady_clock::time_point deadline,
                               const std::atomic<bool>& cancelled) {
  const pid_t child = start_program(program, arguments, folder);
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(child, &status, WNOHANG)) == 0) {
    if (cancelled || std::chrono::steady_clock::now() >= deadline) {
      kill(-child, SIGKILL);
      waitpid(child, &status, 0);
      return std::nullopt;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (ended != child) throw RunError(fmt::format("{} is lost", program.string()));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace ringsplat
