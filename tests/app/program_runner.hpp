#pragma once
#include <sys/wait.h>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"

/// Runs the real program and keeps its output.
namespace ringsplat::app_test {

namespace fs = std::filesystem;

using support::files_in;
using support::TemporaryFolder;

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

struct Ended {
  int code = -1;  ///< 124 when it had to be killed
  std::string out, err;
  double seconds = 0;
};

inline std::string quoted(const std::string& word) {
  std::string safe("'");
  for (const char c : word) c == '\'' ? safe.append("'\\''") : safe.append(1, c);
  return safe.append("'");
}

/// Runs a shell command; kills it after a minute. `input` is its stdin.
inline Ended run_command(const std::string& command, const std::string& input = {}) {
  const TemporaryFolder said;
  write_text(said / "in", input);
  std::string line = "timeout -k 2 60 " + command;
  line += " >" + quoted(said / "out") + " 2>" + quoted(said / "err") + " <" + quoted(said / "in");
  const auto start = std::chrono::steady_clock::now();
  const int status = std::system(line.c_str());
  Ended ended;
  ended.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ended.out = read_text(said / "out");
  ended.err = read_text(said / "err");
  return ended;
}

inline std::string command_of(const std::string& program, const std::vector<std::string>& arguments) {
  std::string command = quoted(program);
  for (const auto& argument : arguments) command.append(" ").append(quoted(argument));
  return command;
}

/// Runs the program; `ranks` 0: without a launcher. `input` is its stdin.
inline Ended run_program(const std::vector<std::string>& arguments, int ranks = 0,
                         const std::string& input = {}) {
  std::string command;
  if (ranks > 0) command += quoted(RINGSPLAT_MPIEXEC) + " -n " + std::to_string(ranks) + " ";
  return run_command(command.append(command_of(RINGSPLAT_PROGRAM, arguments)), input);
}

/// Ranks of one job that are started differently: `ranks` of `program` with `arguments`, in `folder`.
struct RankGroup {
  int ranks = 1;
  fs::path folder;
  std::vector<std::string> arguments;
  std::string program = RINGSPLAT_PROGRAM;
};

inline Ended run_groups(const std::vector<RankGroup>& groups) {
  std::string command;
  for (const auto& group : groups) {
    command.append(command.empty() ? quoted(RINGSPLAT_MPIEXEC) : " :");
    command.append(" -n ").append(std::to_string(group.ranks));
    command.append(" -wdir ").append(quoted(group.folder.string()));
    command.append(" ").append(command_of(group.program, group.arguments));
  }
  return run_command(command);
}

inline std::vector<std::string> lines_with(const std::string& text, const std::string& part) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (line.find(part) != std::string::npos) lines.push_back(line);
    at = end + 1;
  }
  return lines;
}

}  // namespace ringsplat::app_test
